"""What is the machine, and what must it meet? Machine files, criteria files, and the quantities in both."""
