"""A kernel's statements where they stand in another: instead of returning they go on behind their end."""

import ast

from host_tools.kernels.program import BOOL, INT, LOOPS, OBJECT, statements_of


def has_return(nodes):
    """True if any of the statements, or a statement inside them, returns."""
    return any(isinstance(each, ast.Return) for each in statements_of(nodes))


def always_returns(nodes):
    last = nodes[-1] if nodes else None
    return isinstance(last, ast.Return) or isinstance(last, ast.If) and always_returns(last.body) and always_returns(last.orelse)


def name_node(of, store=False):
    return ast.Name(of, ast.Store() if store else ast.Load())


def assign_node(target, value):
    return ast.Assign([name_node(target, True)], value, lineno=1)


def cast_node(kind, node):
    return ast.Call(name_node(kind), [node], [])


class FallThrough:
    """`caller` has local() and kind(); `result`: its local for the returned value, or None."""

    def __init__(self, caller, result):
        self.caller, self.result = caller, result

    def flatten_returns(self, nodes):
        return self._flatten_nodes(nodes)[0]

    def _flatten_nodes(self, nodes, flag=None):
        """Statements that go on behind their end where they returned: (statements, flag), the flag being 1 after a return in a
        loop, or in an if of which neither way always returns."""
        out = []
        for number, node in enumerate(nodes):
            rest = nodes[number + 1 :]
            if isinstance(node, ast.Return):
                if self.result and node.value is not None:
                    known = self.caller.kind_of(node.value)
                    out.append(assign_node(self.result, cast_node(INT, node.value) if known in (BOOL, OBJECT) else node.value))
                elif node.value is not None and not isinstance(node.value, (ast.Name, ast.Constant)):
                    out.append(ast.Expr(node.value))
                if flag:
                    out.append(assign_node(flag, ast.Constant(1)))
                return out, flag
            if not isinstance(node, (ast.If, *LOOPS)) or not has_return([node]):
                out.append(node)
                continue
            if isinstance(node, ast.If) and flag is None and (always_returns(node.body) or always_returns(node.orelse) or not rest):
                body, orelse = node.body, node.orelse
                if always_returns(body):
                    orelse = orelse + rest
                elif always_returns(orelse):
                    body = body + rest
                body, orelse = self._flatten_nodes(body)[0], self._flatten_nodes(orelse)[0]
                out.append(ast.If(node.test, body or [ast.Pass()], orelse))
                return out, flag
            mark = flag or self.caller.new_local(INT)
            if flag is None:
                out.append(assign_node(mark, ast.Constant(0)))
            if isinstance(node, ast.If):
                node.body = self._flatten_nodes(node.body, mark)[0] or [ast.Pass()]
                node.orelse = self._flatten_nodes(node.orelse, mark)[0]
            else:
                node.body = self._in_loop(node.body, mark)
            out.append(node)
            if rest:
                out.append(ast.If(ast.UnaryOp(ast.Not(), name_node(mark)), self._flatten_nodes(rest, mark)[0], []))
            return out, mark
        return out, flag

    def _in_loop(self, nodes, mark):
        """A loop's statements: a return in them leaves it."""
        out = []
        for number, node in enumerate(nodes):
            if isinstance(node, ast.Return):
                return out + self._flatten_nodes([node], mark)[0] + [ast.Break()]
            if isinstance(node, ast.If) and has_return([node]):
                node.body = self._in_loop(node.body, mark)
                node.orelse = self._in_loop(node.orelse, mark)
            elif isinstance(node, LOOPS) and has_return([node]):
                node.body = self._in_loop(node.body, mark)
                out += [node, ast.If(name_node(mark), [ast.Break()], [])]
                continue
            out.append(node)
        return out

