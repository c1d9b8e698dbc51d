"""Programs that measure the tests, or record what they did."""
