"""`passo panel`: the page on a PC, beside a board on a cable or a virtual one."""
