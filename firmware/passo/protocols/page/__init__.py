"""The language of pages: what a page may order, as JSON, becomes commands, and the machine's report what a page is shown.

    web/page_line.py ─► Page (protocol.py): messages ─► Orders (orders.py): fields, who may, when ─► a PageMachine: commands

There is a machine for the language of each board's other links (grbl.py, plotter.py …): it says what a page of such a machine shows, and
what it may ask for. A PC's page has the same orders and machines, which a wire tells by cable (host_tools/page).
"""


def create(kind, number, board, controller, spoken):
    """`kind`: the class of the machine; `spoken`: what its link speaks besides, or else that language's
    package."""
    from passo.protocols import extended
    from passo.protocols.page.protocol import Page  # late: this package is imported before each of its modules

    language = board["links"][number]["protocol"]
    return extended(Page(lambda tell: kind(controller.machine, number, board, tell, spoken), language), board, "page")
