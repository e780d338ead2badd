"""The libraries made to compute as on other processors: runs move between them, and all tests pass on each.

sh scripts/processors                  # runs of the whole gallery, begun on each and resumed on each other
sh scripts/processors --all            # then all tests, golden runs, recorded numbers and validations on each
"""
