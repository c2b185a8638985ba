"""The service's API over a scripted plant, for the tests of the page and for looking at it.

    python mock.py [--port 8099] [--role administer] [--token T]
"""

import argparse
import json
import queue
import socket
import threading
import time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import parse_qs, unquote, urlsplit

import plant

PAGE = Path(__file__).resolve().parent.parent
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
TYPES = {".html": "text/html; charset=utf-8", ".css": "text/css", ".js": "text/javascript"}
HEARTBEAT_S = 10.0


class Mock:
    """A service that tests can bend: hang, fail, fall silent, stop and come back."""

    def __init__(self, port=0, role="administer", token=None, pace_s=0.1):
        self.role, self.token, self.pace_s = role, token, pace_s
        self.machines, self.alarms, self.events = plant.machines(), plant.alarms(), {}
        for own in self.alarms.values():
            self.tell(own, "raised", own["raised_ms"], None, f"{own['source']} above its limit")
            if own["named_ms"]:
                self.tell(own, "named", own["named_ms"], None, own["fault"])
            if own["acknowledged"]:
                seen = own["acknowledged"]
                self.tell(own, "acknowledged", seen["at_ms"], seen["by"], seen["comment"])
        self.faults, self.posts, self.streams = [], [], []
        self.started_ms = plant.now_ms()
        # Paths that answer late or wrongly: {start of the path: seconds or (status, message)}.
        self.slow, self.broken = {}, {}
        self.silent = False
        # How long a trend is under way.
        self.late_s = 0.0
        self.port, self.server = port, None
        self.start()
        threading.Thread(target=self.run, daemon=True).start()

    # What happens on its own

    def run(self):
        beat = time.monotonic()
        turn = 0
        while True:
            time.sleep(self.pace_s)
            turn += 1
            if self.silent:
                continue
            for machine in self.machines.values():
                at = machine.last_ms()
                if at is None or machine.stopped_ms is not None:
                    continue
                values = [machine.value(row, at) for row in range(len(machine.rows()))]
                pairs = [None if value is None else [value, value] for value in values]
                self.send("sample", {"machine": machine.name, "time_ms": at, "series": pairs})
            if turn % 5 == 0:
                for machine in self.machines.values():
                    self.send("machine", self.message(machine))
            if time.monotonic() - beat > HEARTBEAT_S:
                beat = time.monotonic()
                self.send(None, None)

    def send(self, event, data):
        text = ": alive\n\n" if event is None else f"event: {event}\ndata: {json.dumps(data)}\n\n"
        for stream in list(self.streams):
            stream.put(text)

    def message(self, machine):
        open_ones = [own for own in self.alarms.values() if own["state"] != "normal"]
        return machine.message(sum(own["machine"] == machine.name for own in open_ones))

    def tell(self, own, event, time_ms, by, text):
        entry = {"time_ms": time_ms, "event": event, "by": by, "text": text}
        self.events.setdefault(own["id"], []).append(entry)

    def put_alarm(self, own, event="raised"):
        """A new or changed alarm, to all that listen."""
        self.alarms[own["id"]] = own
        self.tell(own, event, plant.now_ms(), None, own["fault"] or own["source"])
        self.send("alarm", own)

    def find(self, case, unit):
        """The alarm that follows a fault that was tried."""
        at = plant.now_ms()
        found = plant.named(case, at - 2000, 0.4, unit, 0.95)
        self.put_alarm(plant.alarm(1000 + len(self.alarms), "GT-02", severity=640, **found))

    # Stop and come back

    def start(self):
        handler = type("Handler", (Handler,), {"mock": self})
        self.server = Server(("127.0.0.1", self.port), handler)
        self.port = self.server.server_address[1]
        threading.Thread(target=self.server.serve_forever, args=(0.05,), daemon=True).start()

    def stop(self):
        self.server.shutdown()
        self.server.server_close()
        for stream in list(self.streams):
            stream.put(None)
        for connection in list(self.server.connections):
            try:
                connection.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass

    @property
    def url(self):
        return f"http://127.0.0.1:{self.port}/"


class Server(ThreadingHTTPServer):
    """Knows its connections, so that a stop ends them."""

    daemon_threads = True
    request_queue_size = 64

    def __init__(self, *arguments):
        self.connections = set()
        super().__init__(*arguments)

    def process_request(self, request, address):
        self.connections.add(request)
        super().process_request(request, address)

    def shutdown_request(self, request):
        self.connections.discard(request)
        super().shutdown_request(request)

    def handle_error(self, request, client_address):
        """Clients that go away are no news."""


class Refusal(Exception):
    """An answer that is an error."""

    def __init__(self, status, code, message):
        super().__init__(message)
        self.status, self.code = status, code


class Handler(BaseHTTPRequestHandler):
    """One request."""

    protocol_version = "HTTP/1.1"
    mock = None

    def log_message(self, *arguments):
        """Quiet."""

    def answer(self, status, body, kind="application/json"):
        data = body if isinstance(body, bytes) else json.dumps(body).encode()
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Content-Security-Policy", POLICY)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(data)

    def handle_method(self):
        url = urlsplit(self.path)
        parts = [unquote(part) for part in url.path.split("/")[1:]]
        length = int(self.headers.get("Content-Length") or 0)
        body = json.loads(self.rfile.read(length)) if length else None
        try:
            if parts[:2] != ["api", "v1"]:
                return self.file(parts)
            self.bend("/".join(parts[2:]))
            if self.mock.token and self.headers.get("Authorization") != f"Bearer {self.mock.token}":
                raise Refusal(401, "unauthorized", "a token is required")
            query = {key: values[0] for key, values in parse_qs(url.query).items()}
            return self.call(parts[2:], query, body)
        except Refusal as refusal:
            error = {"code": refusal.code, "message": str(refusal)}
            return self.answer(refusal.status, {"error": error})

    do_GET = do_POST = do_DELETE = handle_method

    def bend(self, path):
        for start, seconds in list(self.mock.slow.items()):
            if path.startswith(start):
                time.sleep(seconds)
        for start, (status, message) in list(self.mock.broken.items()):
            if path.startswith(start):
                raise Refusal(status, "internal", message)

    def file(self, parts):
        found = PAGE / (parts[0] or "index.html")
        if len(parts) != 1 or found.suffix not in TYPES or not found.is_file():
            raise Refusal(404, "not_found", f"no page {self.path}")
        return self.answer(200, found.read_bytes(), TYPES[found.suffix])

    def call(self, parts, query, body):
        mock = self.mock
        match (self.command, *parts):
            case ("GET", "info"):
                return self.answer(200, {
                    "version": "0.1.0", "role": mock.role, "token_required": mock.token is not None,
                    "embedded_plant": True, "started_ms": mock.started_ms, "now_ms": plant.now_ms(),
                })
            case ("GET", "machines"):
                all_of_them = [mock.message(machine) for machine in mock.machines.values()]
                return self.answer(200, {"machines": all_of_them})
            case ("GET", "machines", name, "trend"):
                seconds, points = int(query.get("seconds", 600)), int(query.get("points", 600))
                trend = self.machine(name).trend(seconds, points)
                time.sleep(mock.late_s)
                return self.answer(200, trend)
            case ("GET", "alarms"):
                return self.answer(200, {"alarms": self.chosen(query)})
            case ("GET", "alarms", number, "events"):
                self.alarm(number)
                return self.answer(200, {"events": mock.events.get(number, [])})
            case ("POST", "alarms", number, action):
                return self.act(number, action, body)
            case ("GET", "faults"):
                return self.answer(200, {"faults": mock.faults})
            case ("POST", "faults"):
                self.may("administer")
                unit = "s" if body["case"] == "fuel_actuator_lag" else "%"
                mock.posts.append(("faults", body))
                mock.faults.append({"case": body["case"], "onset_ms": plant.now_ms(), "size": 0.0, "unit": unit})
                threading.Timer(2.0, mock.find, (body["case"], unit)).start()
                return self.answer(201, mock.faults[-1])
            case ("DELETE", "faults"):
                self.may("administer")
                mock.posts.append(("faults", None))
                mock.faults.clear()
                return self.answer(200, {"faults": []})
            case ("GET", "events"):
                return self.stream()
        raise Refusal(404, "not_found", f"no call {self.command} {self.path}")

    def machine(self, name):
        if name not in self.mock.machines:
            raise Refusal(404, "not_found", f"no machine {name}")
        return self.mock.machines[name]

    def alarm(self, number):
        if number not in self.mock.alarms:
            raise Refusal(404, "not_found", f"no alarm {number}")
        return self.mock.alarms[number]

    def may(self, role):
        roles = ["read", "operate", "administer"]
        if roles.index(self.mock.role) < roles.index(role):
            raise Refusal(403, "forbidden", f"the role {role} is needed")

    def chosen(self, query):
        is_open = query.get("open") == "true"
        found = [own for own in self.mock.alarms.values() if (own["state"] != "normal") == is_open]
        if query.get("machine"):
            found = [own for own in found if own["machine"] == query["machine"]]
        since_ms = int(query.get("since_ms", 0))
        found = [own for own in found if own["raised_ms"] >= since_ms]
        return found[: int(query.get("limit", 1000))]

    def act(self, number, action, body):
        self.may("operate")
        own = dict(self.alarm(number))
        self.mock.posts.append((f"{number}/{action}", body))
        at = plant.now_ms()
        if action == "acknowledge":
            own["acknowledged"] = {"by": body["by"], "at_ms": at, "comment": body["comment"]}
            own["state"] = "active_acknowledged" if own["state"].startswith("active") else "normal"
            event, text = "acknowledged", body["comment"]
        elif action == "shelve":
            until_ms = at + 60_000 * body["minutes"]
            own["shelved"] = {"until_ms": until_ms, "reason": body["reason"], "by": body["by"]}
            event, text = "shelved", body["reason"]
        elif action == "unshelve":
            own["shelved"], event, text = None, "unshelved", ""
        else:
            raise Refusal(404, "not_found", f"no action {action}")
        self.mock.alarms[number] = own
        self.mock.tell(own, event, at, body["by"], text)
        self.mock.send("alarm", own)
        return self.answer(200, own)

    def stream(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Connection", "close")
        self.end_headers()
        self.close_connection = True
        own = queue.Queue()
        self.mock.streams.append(own)
        try:
            while (text := own.get()) is not None:
                self.wfile.write(text.encode())
                self.wfile.flush()
        except OSError:
            pass
        finally:
            self.mock.streams.remove(own)


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--port", type=int, default=8099)
    options.add_argument("--role", default="administer", choices=["read", "operate", "administer"])
    options.add_argument("--token")
    given = options.parse_args()
    mock = Mock(given.port, given.role, given.token)
    print(mock.url, flush=True)
    threading.Event().wait()


if __name__ == "__main__":
    main()
