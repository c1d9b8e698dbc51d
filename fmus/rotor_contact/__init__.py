"""Plant: a flexible rotor whose journals can touch their retainer bearings."""
