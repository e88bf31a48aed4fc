"""Texts of typer itself in the language chosen: usage, the frames of --help, errors of a command line. Typer has no catalogue.

    translate_command_line(typer.main.get_command(app))
"""

import typer

from host_tools.language import N_, _, reword_text

FRAMES = {
    "ARGUMENTS_PANEL_TITLE": N_("Arguments"), "OPTIONS_PANEL_TITLE": N_("Options"), "COMMANDS_PANEL_TITLE": N_("Commands"),
    "ERRORS_PANEL_TITLE": N_("Error"), "ABORTED_TEXT": N_("Aborted."), "DEFAULT_STRING": N_("[default: {}]"),
    "REQUIRED_LONG_STRING": N_("[required]"), "ENVVAR_STRING": N_("[env var: {}]"),
    "RICH_HELP": N_("Try [blue]'{command_path} {help_option}'[/] for help."),
}  # fmt: skip
USAGE = (N_("Usage:"), N_("[OPTIONS]"), N_("COMMAND [ARGS]..."))
SENTENCES = (
    N_("No such option: {} (Possible options: {})"), N_("No such option: {}"), N_("No such command {}. Did you mean {}?"),
    N_("No such command {}."), N_("Missing command."), N_("Missing argument {}."), N_("Missing option {}."),
    N_("Option {} requires an argument."), N_("Option {} does not take a value."), N_("Got unexpected extra argument(s) ({})"),
    N_("Invalid value for {}: {}"), N_("Input should be greater than or equal to {}"), N_("Input should be less than or equal to {}"),
    N_("Input should be a valid number, unable to parse string as a number"),
    N_("Input should be a valid integer, unable to parse string as an integer"),
)  # fmt: skip


def translate_command_line(command):
    """Translate usage and errors that a command of click and its subcommands make themselves, into the language chosen by then."""
    for name in ("make_context", "invoke"):
        setattr(command, name, _reword_refusals(getattr(command, name)))
    waiting = [command]
    for each in waiting:
        each.get_usage = _translate_usage(each.get_usage)
        waiting += getattr(each, "commands", {}).values()


def _reword_refusals(plain):
    """Return a function that calls `plain` and translates the message of an error of the command line."""
    refusal = typer.BadParameter.__mro__[2]  # the base of all errors of a command line, which typer names in some versions only

    def call_reworded(*arguments, **named):
        """Call `plain`. Raises its error with the message translated."""
        try:
            return plain(*arguments, **named)
        except refusal as error:
            text = reword_text(error.format_message(), SENTENCES)
            error.format_message = lambda: text
            raise

    return call_reworded


def _translate_usage(plain):
    """Return a get_usage() that translates the text of `plain`, and typer's frames."""

    def get_usage(context):
        """Return the usage in the language chosen."""
        from typer import rich_utils  # which takes a while, and is there already: this is shown by it

        for name, text in FRAMES.items():
            setattr(rich_utils, name, _(text))
        option = context.command.get_help_option(context)
        if option:
            option.help = _("Show this message and exit.")
        usage = plain(context)
        for text in USAGE:
            usage = usage.replace(text, _(text), 1)
        return usage

    return get_usage
