"""How does the machine behave in the states that the analyses examine?"""
