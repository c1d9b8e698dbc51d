"""Which criteria does the machine meet? Runs all analyses and judges what they compute."""
