# SPDX-License-Identifier: MIT
"""`palpate live` from outside: its page in a real browser, its recording, and what it refuses.

usage: live.py PALPATE SCENE OUT [--pictures DIR]
"""

import base64
import csv
import http.client
import json
import os
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from random import Random

from chromium import Page, browser_path


def expect(right, what):
    if not right:
        raise AssertionError("not so: " + what)


class Live:
    """A running `palpate live`."""

    def __init__(self, palpate, scene, out, *options):
        shutil.rmtree(out, ignore_errors=True)
        self.process = subprocess.Popen([palpate, "live", scene, "--out", out, *options], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, text=True)
        self.url = self.process.stdout.readline().strip()
        if not self.url.startswith("http://127.0.0.1:"):
            raise SystemExit("no address: " + self.url + self.process.stderr.read())
        self.port = int(self.url.split(":")[2].split("/")[0])
        self.token = self.url.split("token=")[1]

    def end(self, sign=signal.SIGINT):
        self.process.send_signal(sign)
        self.text, self.errors = self.process.communicate(timeout=20)
        return self.process.returncode

    def status(self, target, **headers):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
        connection.request("GET", target, headers=headers)
        return connection.getresponse().status


class Viewer:
    """A WebSocket client on a plain socket."""

    def __init__(self, live, buffer=0):
        self.socket = socket.socket()
        if buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.socket.settimeout(10)
        self.socket.connect(("127.0.0.1", live.port))
        self.socket.sendall(Viewer.request(live))
        self.rest = b""
        while b"\r\n\r\n" not in self.rest:
            self.rest += self.receive()
        head, self.rest = self.rest.split(b"\r\n\r\n", 1)
        expect(b" 101 " in head.split(b"\r\n")[0], "the socket opens: " + head.decode())

    @staticmethod
    def request(live):
        key = base64.b64encode(os.urandom(16)).decode()
        return (f"GET /socket?token={live.token} HTTP/1.1\r\nHost: 127.0.0.1:{live.port}\r\n"
                f"Origin: http://127.0.0.1:{live.port}\r\nUpgrade: websocket\r\n"
                f"Connection: Upgrade\r\nSec-WebSocket-Key: {key}\r\n"
                "Sec-WebSocket-Version: 13\r\n\r\n").encode()

    @staticmethod
    def framed(data, kind=1):
        size = bytes([128 | len(data)]) if len(data) < 126 else bytes([254]) + struct.pack(">H", len(data))
        return bytes([128 | kind]) + size + bytes(4) + data  # a mask of zeros

    def receive(self):
        bytes_read = self.socket.recv(65536)
        if not bytes_read:
            raise ConnectionError("closed")
        return bytes_read

    def take(self, count):
        while len(self.rest) < count:
            self.rest += self.receive()
        taken, self.rest = self.rest[:count], self.rest[count:]
        return taken

    def state(self):
        """State of the next frame."""
        while True:
            first, size = self.take(2)
            if size == 126:
                size = struct.unpack(">H", self.take(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self.take(8))[0]
            data = self.take(size)
            if first & 15 == 2:
                return json.loads(data[8:8 + struct.unpack("<I", data[4:8])[0]])
            if first & 15 == 9:  # ping
                self.send(data, 10)

    def send(self, data, kind=1):
        if isinstance(data, dict):
            data = json.dumps(data).encode()
        self.socket.sendall(Viewer.framed(data, kind))

    def wait(self, holds, what, patience=15):
        deadline = time.monotonic() + patience
        state = self.state()
        while not holds(state):
            expect(time.monotonic() < deadline, what + "; last state " + json.dumps(state))
            state = self.state()
        return state


def refusals(live):
    """Nothing but the page of the token is served, to nobody but a page of this machine."""
    page = "/?token=" + live.token
    silent = [socket.create_connection(("127.0.0.1", live.port)) for _ in range(80)]
    expect(live.status(page) == 200, "the page is served with the token, also beside connections that send nothing")
    for each in silent:
        each.close()
    here = f"127.0.0.1:{live.port}"
    for target in ("/", "/?token=" + "0" * 32, page + "0", "/etc/passwd?token=" + live.token,
                   "/../../etc/passwd", "/socket?token=" + live.token):
        expect(live.status(target) == 403, target + " is refused")
    expect(live.status(page, Host="example.org") == 403, "another host is refused")
    for origin in ("http://example.org", "null", f"https://{here}"):
        status = live.status("/socket?token=" + live.token, Origin=origin, Upgrade="websocket", Connection="Upgrade",
                             **{"Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==", "Sec-WebSocket-Version": "13"})
        expect(status == 403, "origin " + origin + " is refused")
        expect(live.status(page, Origin=origin) == 403, "the page is refused to origin " + origin)
    for text in (b"nonsense\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"GET / HTTP/1.1\r\nno colon\r\n\r\n",
                 b"GET / HTTP/1.1\r\nx: " + b"a" * 100000 + b"\r\n\r\n"):
        with socket.create_connection(("127.0.0.1", live.port), 10) as raw:
            try:
                raw.sendall(text)
                answer = raw.recv(64)
            except ConnectionError:  # it need not read the rest of a long header
                answer = b"HTTP/1.1 400"
            expect(answer.startswith(b"HTTP/1.1 400"), f"{text[:30]} is answered as a bad request")
    other = socket.socket()
    addresses = [line.split()[1] for line in open("/proc/net/tcp").readlines()[1:] if line.split()[3] == "0A"]
    expect(f"0100007F:{live.port:04X}" in addresses, "it listens on 127.0.0.1")
    expect(f"00000000:{live.port:04X}" not in addresses, "it listens on no other address")
    other.close()


def viewers(live):
    """One writer; a message that is too long, or too many, end a connection; a viewer that never reads loses frames."""
    first, second = Viewer(live), Viewer(live)
    first.wait(lambda state: state["writer"] == "nobody", "the page of the test before has left")
    first.send({"do": "pause"})
    first.wait(lambda state: state["writer"] == "you" and not state["running"], "the first viewer operates")
    second.wait(lambda state: state["writer"] == "another" and not state["running"], "the second viewer watches")
    second.send({"do": "start"})
    for _ in range(40):
        expect(not second.state()["running"], "the second viewer cannot start the run")
    first.socket.close()
    second.wait(lambda state: state["writer"] == "nobody", "a viewer that left operates no more")
    second.send({"do": "start"})
    second.wait(lambda state: state["running"], "then the next one operates")
    for kind, send in (("long", lambda viewer: viewer.send(b"x" * 2000)),
                       ("frequent", lambda viewer: [viewer.send({"do": "start"}) for _ in range(2000)])):
        loud = Viewer(live)
        try:
            send(loud)
            while True:
                loud.state()
        except (ConnectionError, OSError):
            pass
        else:
            expect(False, kind + " messages end a connection")
    deaf = Viewer(live, buffer=4096)
    begin = second.state()
    state = second.wait(lambda state: state["periods"] > begin["periods"] + 6000, "the loop goes on beside a deaf viewer", 30)
    expect(state["torn"] == 0, "no frame is torn")
    deaf.socket.close()
    second.send({"do": "pause"})
    second.socket.close()


def dying_clients(live):
    """Clients that are cut off at any byte: in the request, in the answer, in a message, in a frame."""
    watching = Viewer(live)
    begin = watching.state()
    random = Random(7)
    for n in range(60):
        dying = socket.create_connection(("127.0.0.1", live.port), 10)
        # A reset instead of a farewell, as when the kernel closes the sockets of a killed process.
        dying.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        request = Viewer.request(live)
        whole = n % 3 != 0
        dying.sendall(request if whole else request[:random.randrange(len(request))])
        if whole:
            for _ in range(random.randrange(1, 4)):
                dying.recv(random.randrange(1, 3000))
            message = Viewer.framed(json.dumps({"do": "hold", "value": 0.001}).encode())
            dying.sendall(message[:random.randrange(1, len(message) + 1)])
        time.sleep(0.01 * random.random())
        dying.close()
    state = watching.wait(lambda state: state["viewers"] == 1 and state["periods"] > begin["periods"] + 500,
                          "the loop goes on, and nobody is left over")
    expect(state["writer"] == "nobody", "a client that died operates no more")
    expect(state["torn"] == 0, "no frame is torn")
    watching.socket.close()


def killed(palpate, scene, out):
    """The program killed at several moments: whole rows, no half-written file, and the folder can be used again."""
    random = Random(3)
    for _ in range(6):
        live = Live(palpate, scene, out, "--ordinary")
        viewer = Viewer(live)
        viewer.state()
        time.sleep(random.random())
        live.process.kill()
        live.process.wait()
        try:
            while True:
                viewer.state()
        except (ConnectionError, OSError):
            pass
        for name in os.listdir(out):
            expect(name == "trace.csv", "a killed program leaves its rows alone: " + name)
        with open(out + "/trace.csv") as file:
            lines = file.read().split("\n")
        expect(lines[-1] == "" and len({line.count(",") for line in lines[:-1]}) <= 1, "its rows are whole")


def in_browser(live, page, pictures):
    page.open(live.url)
    root = "document.getElementById('live').dataset"
    expect(page.wait(root + ".state === 'open'"), "the page opens: " + str(page.problems))
    begin = page.value(root + ".frames")
    expect(page.wait(f"Number({root}.frames) > {begin} + 60"), "frames arrive")
    # The mouse holds the grip: the needle goes in, and the texts follow.
    page.value("document.getElementById('live-start').textContent === 'Start' && document.getElementById('live-start').click()")
    left, top, width, height = page.box("#live-grip")
    page.drag((left + width / 2, top + 8), (left + width / 2, top + height - 4), 30)
    number = "parseFloat(document.getElementById('live-says-%s').textContent)"
    expect(page.wait(number % "depth" + " > 0 && " + number % "reaction" + " > 0"), "dragging inserts the needle")
    expect(page.value("document.getElementById('live-says-layer').textContent") != "outside", "the layer is named")
    page.value("document.getElementById('live-grip').focus()")
    for _ in range(30):  # 15 mm back: the tissue holds the shaft
        page.call("Input.dispatchKeyEvent", type="keyDown", key="ArrowUp", code="ArrowUp")
    sign = "document.getElementById('live-says-applied').textContent.startsWith('\u2212')"
    expect(page.wait(sign), "the force follows the arrow keys")
    if pictures:
        page.wait("false", 1.0)
        take_pictures(page, pictures)
    slide(page)
    page.value("document.getElementById('live-reset').click()")
    expect(page.wait("!(" + number % "depth" + " > 0)", 20), "reset begins again")
    expect(not page.problems, "nothing goes wrong on the console: " + str(page.problems))
    foreign = [each for each in page.requests if not each.startswith(
        (f"http://127.0.0.1:{live.port}/", f"ws://127.0.0.1:{live.port}/", "data:", "about:", "blob:"))]
    expect(not foreign, "no request beyond the server: " + str(foreign))


def slide(page):
    """A slider changes a material at a tick border, without a reset."""
    begin = page.value("document.getElementById('live').dataset.run")
    page.value("(() => { const s = document.querySelector('#live-sliders input'); s.value = 0.5;"
               "s.dispatchEvent(new Event('input')); })()")
    expect(page.wait("document.getElementById('live-materials-says').textContent.startsWith('Changed at')"),
           "the material changes while the scene runs")
    expect(page.value("document.getElementById('live').dataset.run") == begin, "without a reset")


def take_pictures(page, folder):
    os.makedirs(folder, exist_ok=True)
    for width, height in ((1280, 900), (390, 844)):
        for theme in ("light", "dark"):
            page.resize(width, height, theme == "dark")
            page.wait("false", 0.8)
            expect(page.value("document.documentElement.scrollWidth <= innerWidth"), f"{width} px suffice")
            page.picture(f"{folder}/live-{width}-{theme}.png", whole=True)
    page.resize(1280, 900)


def rows_of(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def replays(palpate, folder, changes=True):
    """What was done is a scene, and gives the same digits."""
    again = folder + "-again"
    subprocess.run([palpate, "run", folder + "/scene.toml", "--no-view", "--quiet", "--out", again], check=True,
                   stdout=subprocess.DEVNULL)
    with open(folder + "/scene.toml") as file:
        expect(("change = [" in file.read()) == changes, "the scene has the changes of materials")
    live, replayed = rows_of(folder + "/trace.csv"), rows_of(again + "/trace.csv")
    expect(len(live) == len(replayed) > 100, f"a row for every tick: {len(live)} and {len(replayed)}")
    common = [name for name in live[0] if name in replayed[0]]
    expect("tool.force_n" in common and "tool.depth_m" in common, "columns of the tool")
    expect(max(float(row["tool.depth_m"]) for row in live) > 0, "the tool was in the tissue")
    for a, b in zip(live, replayed):
        for name in common:
            expect(float(a[name]) == float(b[name]), f"{name} at {a['time_s']} s: {a[name]} and {b[name]}")


def with_files(palpate, scene, out):
    """A scene that names other files is recorded as one that finds them."""
    live = Live(palpate, scene, out, "--ordinary")
    viewer = Viewer(live)
    viewer.wait(lambda state: state["depth"] > 1e-4 and state["ticks"] > 200, "the tool is driven", 60)
    expect(live.end() == 130, "Ctrl-C ends it: " + live.errors)
    replays(palpate, out, changes=False)


def main():
    palpate, scene, out = sys.argv[1:4]
    pictures = sys.argv[5] if len(sys.argv) > 5 else None
    if browser_path() is None:
        print("skipped: no chromium on this machine")
        raise SystemExit(77)
    live = Live(palpate, scene, out, "--device", "mouse", "--ordinary")
    profile = tempfile.mkdtemp()
    page = Page(profile)
    try:
        refusals(live)
        in_browser(live, page, pictures)
        page.close()  # killed: the loop goes on
        viewers(live)
        dying_clients(live)
        code = live.end()
        expect(code == 130, f"Ctrl-C ends it with 130, not {code}: {live.errors}")
        expect(" 0 dropped" not in live.text, "the viewer that never reads loses frames: " + live.text)
        expect(" 0 torn" in live.text, "no frame is torn: " + live.text)
        summary = json.load(open(out + "/summary.json"))
        expect(summary["status"] == "ok" and summary["rows"] == summary["steps"] + 1, "the recording is complete")
        replays(palpate, out)
        with_files(palpate, os.path.join(os.path.dirname(scene), "skin-example/scene.toml"), out + "-files")
        killed(palpate, scene, out + "-killed")
    finally:
        page.close()
        live.process.kill()
        shutil.rmtree(profile, ignore_errors=True)
    print(live.text)


if __name__ == "__main__":
    main()
