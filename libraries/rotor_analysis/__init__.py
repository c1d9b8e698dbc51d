"""What a rotor description tells without a simulation: modes, tables, receptance."""
