"""How does the machine behave in each state that analyses look at?"""
