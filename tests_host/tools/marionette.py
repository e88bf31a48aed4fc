"""Firefox for selenium without geckodriver, which Debian does not have: its commands go to Firefox's own port, Marionette.

    with tempfile.TemporaryDirectory() as folder:
        driver = firefox(folder)            # a selenium WebDriver

Marionette's protocol: `LENGTH:JSON` both ways; [0, number, command, parameters] and [1, number, error, result].
"""

import json
import shutil
import socket
import subprocess
import time
from pathlib import Path

from selenium.webdriver.remote.command import Command
from selenium.webdriver.remote.errorhandler import ErrorHandler
from selenium.webdriver.remote.file_detector import UselessFileDetector
from selenium.webdriver.remote.webdriver import WebDriver

FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")
_START_S = 60
_ANSWER_S = 60
_COMMANDS = {
    Command.NEW_SESSION: "NewSession", Command.GET: "Navigate", Command.REFRESH: "Refresh", Command.FIND_ELEMENT: "FindElement",
    Command.FIND_ELEMENTS: "FindElements", Command.FIND_CHILD_ELEMENT: "FindElement", Command.FIND_CHILD_ELEMENTS: "FindElements",
    Command.W3C_EXECUTE_SCRIPT: "ExecuteScript", Command.W3C_EXECUTE_SCRIPT_ASYNC: "ExecuteAsyncScript", Command.CLICK_ELEMENT: "ElementClick",
    Command.CLEAR_ELEMENT: "ElementClear", Command.SEND_KEYS_TO_ELEMENT: "ElementSendKeys", Command.GET_ELEMENT_TEXT: "GetElementText",
    Command.IS_ELEMENT_ENABLED: "IsElementEnabled", Command.GET_ELEMENT_RECT: "GetElementRect", Command.GET_ELEMENT_TAG_NAME: "GetElementTagName",
    Command.GET_ELEMENT_ATTRIBUTE: "GetElementAttribute", Command.W3C_ACTIONS: "PerformActions", Command.W3C_CLEAR_ACTIONS: "ReleaseActions",
    Command.SCREENSHOT: "TakeScreenshot", Command.SET_WINDOW_RECT: "SetWindowRect", Command.GET_WINDOW_RECT: "GetWindowRect",
    Command.GET_CURRENT_URL: "GetCurrentURL", Command.SET_TIMEOUTS: "SetTimeouts", Command.QUIT: "DeleteSession",
}  # fmt: skip


class Port:
    """Marionette's, as selenium asks of whatever carries out its commands."""

    w3c = True
    keep_alive = True

    def __init__(self, port):
        deadline = time.monotonic() + _START_S
        while True:
            try:
                self._socket = socket.create_connection(("127.0.0.1", port), timeout=_ANSWER_S)
                break
            except OSError:
                assert time.monotonic() < deadline, "Firefox does not listen"
                time.sleep(0.2)
        self._number = 0
        self._hear()  # its greeting

    def _hear(self):
        size = b""
        while not size.endswith(b":"):
            size += self._socket.recv(1)
        data = b""
        while len(data) < int(size[:-1]):
            data += self._socket.recv(int(size[:-1]) - len(data))
        return json.loads(data)

    def execute(self, command, params):
        """The answer to a command of selenium's, in the form of WebDriver's."""
        params = {key: value for key, value in (params or {}).items() if key != "sessionId"}
        if command == Command.NEW_SESSION:
            params = params["capabilities"].get("alwaysMatch", {})
        if command in (Command.FIND_CHILD_ELEMENT, Command.FIND_CHILD_ELEMENTS):
            params["element"] = params.pop("id")
        if command == Command.SEND_KEYS_TO_ELEMENT:
            params.pop("value", None)
        self._number += 1
        text = json.dumps([0, self._number, "WebDriver:" + _COMMANDS[command], params])
        self._socket.sendall(f"{len(text.encode())}:{text}".encode())
        _, _, error, result = self._hear()
        if error:
            return {"status": 500, "value": json.dumps({"value": error})}
        plain = isinstance(result, dict) and set(result) == {"value"}
        return {"status": 0, "value": result["value"] if plain else result, **(result if command == Command.NEW_SESSION else {})}

    def close(self):
        self._socket.close()


class Firefox(WebDriver):
    def __init__(self, process, port, options):
        self._process = process
        WebDriver.__init__(self, command_executor=Port(port), options=options, file_detector=UselessFileDetector())  # files are this computer's
        self.error_handler = ErrorHandler()

    def get_log(self, kind):
        """Firefox tells no log."""
        return []

    def quit(self):
        self._process.terminate()
        self._process.wait(30)


def firefox(folder):
    """A Firefox of its own, without a window, with its profile in `folder`."""
    from selenium import webdriver

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    profile = Path(folder) / "profile"
    profile.mkdir()
    (profile / "user.js").write_text(f'user_pref("marionette.port", {port});\nuser_pref("browser.shell.checkDefaultBrowser", false);\n'
                                     'user_pref("datareporting.policy.dataSubmissionEnabled", false);\n')  # fmt: skip
    words = [FIREFOX, "--headless", "--marionette", "--no-remote", "--profile", str(profile)]
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return Firefox(process, port, webdriver.FirefoxOptions())
