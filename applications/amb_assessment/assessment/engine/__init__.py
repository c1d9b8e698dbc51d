"""Which criteria does the machine meet? The engine runs all analyses and judges what they compute."""
