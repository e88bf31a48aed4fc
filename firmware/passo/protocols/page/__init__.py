"""The language of pages: a page's orders, as JSON, become commands, and the machine's report becomes the page's state.

    web/page_line.py ─► Page (protocol.py): messages ─► Orders (orders.py): fields, who may, when ─► a PageMachine: commands

There is a machine for the language of each board's other links (grbl.py, plotter.py …), with the state and the orders of its page. A PC's
page has the same orders and machines, which a wire tells by cable (host_tools/page).
"""


def create(kind, number, board, controller, spoken):
    """Create the page's protocol for link `number`. `kind`: the class of its machine; `spoken`: the protocol that the link speaks besides, or else
    that language's package."""
    from passo.protocols import extend_language
    from passo.protocols.page.protocol import Page  # late: this package is imported before each of its modules

    language = board["links"][number]["protocol"]
    return extend_language(Page(lambda tell: kind(controller.machine, number, board, tell, spoken), language), board, "page")
