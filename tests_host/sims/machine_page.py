"""A browser at the machine's own PC: orders of `passo agent --at-machine`, signed with the page's key.

    page = MachinePage("http://127.0.0.1:8091", key)
    page.machines()
    page.do("plotter-3", "release")         # an answer of requests
"""

import json

import requests

import host_tools  # noqa: F401: before passo
from passo.web.session import Session


class MachinePage:
    def __init__(self, address, key):
        self.address = address.rstrip("/")
        self._key = key
        self._nonce = ""
        self._count = 0

    def machines(self):
        return self._heads(requests.get(self.address + "/machines", timeout=20)).json()

    def _heads(self, answer):
        fresh = answer.headers.get("X-Passo-Nonce", self._nonce)
        self._count = int(answer.headers.get("X-Passo-Count", 0)) if fresh != self._nonce else self._count
        self._nonce = fresh
        return answer

    def proof(self, body):
        """The head's line of an order that nobody has said yet."""
        self._count += 1
        return f"{self._count}.{Session(self._key, self._nonce).proof(str(self._count), 'POST /do ' + body)}"

    def do(self, name, what, **headers):
        if not self._nonce:
            self.machines()
        body = json.dumps({"name": name, "do": what})
        return self._heads(requests.post(self.address + "/do", data=body, headers={"Origin": self.address, "X-Passo": self.proof(body), **headers}, timeout=20))
