"""`python -m stickslip` is the command `stickslip`."""

from .cli import main

main(prog_name="stickslip")
