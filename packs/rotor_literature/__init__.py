"""Published rotors, and scenarios that use them."""
