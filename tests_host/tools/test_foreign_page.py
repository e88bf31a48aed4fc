"""Any page that the user has open in a browser, of another origin than ours: it moves nothing through a TCP port that takes orders."""

import http.server
import threading
import time

import pytest

from host_tools.sim.serial_line import TcpLine
from running_router import Running
from test_panel_page import CHROMIUM, DRIVER, chromium

pytestmark = [
    pytest.mark.unmeasured,
    pytest.mark.xdist_group("panel"),
    pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="NO BROWSER: apt-get install chromium chromium-driver, to test the page"),
]
ORDERS = "\\n$LINK=0\\n$X\\n$J=G91X10F1000\\nG91G1X5F600\\n"
PAGE = """<!doctype html><title>not ours</title><body>
<form id="f" method="post" enctype="text/plain" action="http://127.0.0.1:{port}/" target="w"><textarea name="a"></textarea></form>
<iframe name="w"></iframe><script>
document.querySelector("textarea").value = "{orders}";
document.getElementById("f").submit();
fetch("http://127.0.0.1:{port}/", {{method: "POST", mode: "no-cors", body: "{orders}"}}).catch(() => 0);
fetch("http://127.0.0.1:{port}/?" + "~".repeat(20000), {{mode: "no-cors"}}).catch(() => 0);
try {{ new WebSocket("ws://127.0.0.1:{port}/"); }} catch (error) {{ }}
for (const transport of ["turn:127.0.0.1:{port}?transport=tcp", "turns:127.0.0.1:{port}?transport=tcp"]) {{
  const peer = new RTCPeerConnection({{iceServers: [{{urls: transport, username: "a", credential: "b"}}]}});
  peer.createDataChannel("a");
  peer.createOffer().then((offer) => peer.setLocalDescription(offer));
}}
setTimeout(() => {{ document.title = "done"; }}, 1500);
</script>"""


def test_what_a_page_of_another_origin_can_have_sent():
    """By a form, fetch, a URL longer than any, WebSocket and WebRTC."""
    running = Running(line=TcpLine(0))
    port = int(running.line.name.rsplit(":", 1)[1])
    heard = []
    read = running.line.read
    running.line.read = lambda: heard.append(read()) or heard[-1]

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(PAGE.format(port=port, orders=ORDERS).encode())

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    place = list(running.world.place)
    driver = chromium()
    try:
        driver.get(f"http://127.0.0.1:{server.server_address[1]}/")
        running.until(lambda: driver.title == "done")
        time.sleep(0.2)
        assert running.world.place == place and running.app.controller.state == "alarm"
        assert not b"".join(heard), "not a byte came to the board"
    finally:
        driver.quit()
        server.shutdown()
        running.close()
