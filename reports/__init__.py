"""Reports of the studies: plots, the page on the paper, and the generated tables of docs/tables, from the numbers that
`fabric-study` has written. Nothing here runs a simulation. `python3 -m reports --help` says how."""
