"""Mutation testing: small faults put into the package, each of which the tests of its part should catch.

`sh scripts/mutate --help` says how to run it. `faults` finds the places of a source file that can be changed, `sample`
draws 100 of them, `tree` makes the copy of the checkout in which they are tried, `trial` tries one, `review` holds the
faults of a review, and `results` keeps what came of it, one line of JSON for each trial, in `results.jsonl`.
"""
