"""Published rotors, and scenarios with them."""
