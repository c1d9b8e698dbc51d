"""Controllers as data: from a law in any form to the constants of the model `linear_controller`."""
