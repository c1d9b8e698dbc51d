"""What is the machine, and which criteria must it meet? Machine files, criteria files, and the judged quantities."""
