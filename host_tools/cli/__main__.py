"""`python -m host_tools.cli` is `passo`."""

from host_tools.cli.main import main

main()
