import resource, sys, typer
from host_tools.cli import app
