"""Programs that measure the tests, or record their results; README.md describes each."""
