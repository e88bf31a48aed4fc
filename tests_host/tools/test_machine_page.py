"""The page at the machine (`passo agent --at-machine`): its key starts motion, anybody may stop it, and no log has the key."""

import json
import os
import pty
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest
import requests
from hypothesis import given, settings
from hypothesis import strategies as st

from host_tools import interpreter
from host_tools.cli import key_option
from host_tools.clients import page_key
from host_tools.failure import Failure
from host_tools.shop.local_page import serve
from host_tools.sim.consent import Consent

sys.path.insert(0, str(Path(__file__).parents[1] / "sims"))
from machine_page import MachinePage  # noqa: E402

KEY = "ABCDEFGHJKLMNPQR"
MOVES = ("release", "go", "withdraw", "give up", "jump", "")
SHORT = ("", "ABC", "ABCD-EFGH-JKLM-NPQ", "0O1I" * 8, "a b c d e f g h j k l m n p q", "\n", "é" * 40)


class Served:
    """The page, with an agent that records its orders."""

    def __init__(self):
        self.done, self.stops, self.why = [], [], ""
        self.close, port = serve(0, KEY, lambda: [{"name": "m", "how": "rest"}], lambda name, what: self.done.append((name, what)) or "", self.stop)
        self.address = f"http://127.0.0.1:{port}"

    def stop(self, name):
        self.stops.append(name)
        return self.why

    def post(self, body, **headers):
        return requests.post(self.address + "/do", data=body, headers={"Origin": self.address, **headers}, timeout=20)


@pytest.fixture(scope="module")
def served():
    opened = Served()
    yield opened
    opened.close()


def said(name, what):
    return json.dumps({"name": name, "do": what})


def test_a_program_without_the_key_starts_nothing(served):
    """It claims to be the page, knows the nonce, and repeats messages of others."""
    served.done.clear()
    person = MachinePage(served.address, KEY)
    stranger = MachinePage(served.address, "B" * 16)
    for what in MOVES:
        assert served.post(said("m", what)).status_code == 403
        assert served.post(said("m", what), **{"X-Passo": "1.0.0"}).status_code == 403
    assert stranger.do("m", "release").status_code == 403
    assert served.done == []
    time.sleep(1.1)  # after wrong proofs none is looked at for a second
    person.machines()
    body = said("m", "release")
    proof = person.proof(body)
    assert served.post(body, **{"X-Passo": proof}).status_code == 200
    assert served.done == [("m", "release")]
    for again in (body, said("m", "go"), said("n", "release")):
        assert served.post(again, **{"X-Passo": proof}).status_code == 403, "a proof is good for one order, once"
    assert person.do("m", "go").json()["text"] == "" and served.done == [("m", "release"), ("m", "go")]
    assert requests.post(served.address + "/do", data=body, headers={"Origin": "http://evil.example", "X-Passo": person.proof(body)}, timeout=20).status_code == 403
    assert served.done == [("m", "release"), ("m", "go")]


def test_stop_needs_no_key_and_says_what_did_not_arrive(served):
    served.stops.clear()
    assert served.post(said("m", "stop")).json() == {"text": ""} and served.post(said("", "stop")).status_code == 200
    served.why = "no board answers"
    assert "no board" in served.post(said("m", "stop")).json()["text"]["en"]
    served.why = ""
    assert served.stops == ["m", "", "m"]


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=60) | st.sampled_from([b"[" * 4000, b'{"name":{},"do":[]}', b'{"name":"m","do":5}', b"\xff", b'{"name":"\\ud800","do":"go"}', b"null"]))
def test_any_order_is_answered(served, body):
    served.done.clear()
    assert served.post(body).status_code in (400, 403)
    assert served.done == []


def test_an_agent_tells_its_key_to_a_terminal_or_a_file_and_nobody_else(tmp_path):
    """Into a pipe, as to a log, it prints the page without it; in a terminal with it. The list of processes has none."""
    shop_key, file = tmp_path / "shop.key", tmp_path / "page.key"
    key_option.make_key_file(shop_key)
    words = [*interpreter.passo(), "agent", "--virtual", "m=corexy_plotter", "--broker", "127.0.0.1:1", "--shop-key", str(shop_key), "--at-machine", "0"]
    home = {**os.environ, "HOME": str(tmp_path)}
    logged = subprocess.Popen([*words, "--page-key", str(file)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=home)
    main, end = pty.openpty()
    seen = subprocess.Popen(words, stdout=end, stderr=subprocess.DEVNULL, env=home)
    os.close(end)
    try:
        log = ""
        while "Ctrl-C" not in log:
            log += logged.stdout.readline()
        key = file.read_text().strip()
        assert file.stat().st_mode & 0o777 == 0o600 and len(key) == 16
        assert key not in log and str(file) in log and key not in Path(f"/proc/{logged.pid}/cmdline").read_text()
        address = re.search(r"page: (http://127.0.0.1:\d+/)\n", log)[1]
        assert requests.post(address + "do", data=said("m", "release"), headers={"Origin": address[:-1]}, timeout=20).status_code == 403
        assert MachinePage(address, key).do("m", "give up").status_code == 200
        shown = b""
        while b"Ctrl-C" not in shown:
            shown += os.read(main, 4096)
        found = re.search(rb"page: http://127.0.0.1:\d+/#key=([A-Z2-9]{16})\r\n", shown)
        assert found and found[1].decode() != key and not (tmp_path / ".local").exists()
    finally:
        for each in (logged, seen):
            each.terminate()
            each.wait(30)
        logged.stdout.close()
        os.close(main)


def test_short_keys_are_refused_wherever_one_is_read(tmp_path):
    for text in SHORT:
        with pytest.raises(ValueError):
            page_key.read_key(text)
        with pytest.raises(Failure, match="16 or more"):
            key_option.key_of(text, "PASSO_KEY")
        assert not Consent().admits_token(text)
    for word in ("QWERTYQWERTYQWE", "0" * 16):
        file = tmp_path / "key"
        file.write_text(word + "\n")
        file.chmod(0o600)
        board = ["--virtual", "m=corexy_plotter", "--broker", "127.0.0.1:1"]
        for words in (["agent", *board, "--shop-key", str(file)], ["shop", "--broker", "127.0.0.1:1", "--shop-key", str(file), "--http", "0", "--book", str(tmp_path / "b")],
                      ["board", "--board", "torch_pico_w", "--http", "0", "--key", word], ["wifi", "bridge", "127.0.0.1", "--key", word, "--tcp", "0"]):  # fmt: skip
            ended = subprocess.run([*interpreter.passo(), *words], capture_output=True, text=True, timeout=60)
            assert ended.returncode == 1 and "16 or more of these letters" in ended.stderr and word not in ended.stderr, words
