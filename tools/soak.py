#!/usr/bin/env python3
"""Does what a plant does, for minutes or an hour, and watches whether the server stays as it is.

    tools/soak.py target/release/flankfit [--minutes 5] [--clients 6] [--extra=--store-writers=2 …]

Starts the program on a database of its own. Clients measure, fit again, decide, list, read traces and events, stream blocks, watch
long fits and cancel some, archive and purge, send what is refused, and leave in the middle; jobs come and go all the time. Every
few seconds resident memory, open files, threads and connections are read from /proc (Linux). The first fifth warms up. After it
the level must hold: medians of the first and the last quarter of the rest are compared, and the program ends with 1 where the last
is greater by more than a tenth (memory: and 16 MiB; files, threads and connections: and 8), where anything was answered by 500, or
an audit does not verify. `--minutes 60` is the hour. Standard library only.
"""

import argparse
import http.client
import json
import pathlib
import random
import socket
import statistics
import subprocess
import sys
import tempfile
import threading
import time

MIB = 1 << 20


class Server:
    """The program, on a free port and a database in a directory that goes away."""

    def __init__(self, program, extra):
        self.directory = tempfile.TemporaryDirectory()
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        url = f"sqlite://{self.directory.name}/soak.db"
        command = [program, "serve", "--bind", f"127.0.0.1:{self.port}", "--database-url", url, "--log", "error", "--auth", "off"]
        self.process = subprocess.Popen([*command, *extra], stderr=subprocess.DEVNULL)
        for _ in range(600):
            try:
                if self.call("GET", "/readyz")[0] == 200:
                    return
            except OSError:
                pass
            time.sleep(0.05)
        raise SystemExit("the server does not start")

    def call(self, method, path, body=None, headers=None, keep=None):
        """Status, headers and body of an answer; on a connection of its own unless one is kept."""
        connection = keep or http.client.HTTPConnection("127.0.0.1", self.port, timeout=120)
        text = body if isinstance(body, (bytes, type(None))) else json.dumps(body).encode()
        try:
            connection.request(method, path, text, {"Content-Type": "application/json", **(headers or {})})
            answer = connection.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            if keep is None:
                connection.close()

    def level(self):
        """Resident memory, open files, threads, connections."""
        process = pathlib.Path(f"/proc/{self.process.pid}")
        fields = dict(line.split(":", 1) for line in (process / "status").read_text().splitlines())
        here = f":{self.port:04X}"
        lines = (process / "net/tcp").read_text().splitlines()[1:]
        established = sum(line.split()[1].endswith(here) and line.split()[3] == "01" for line in lines)
        files = len(list((process / "fd").iterdir()))
        return int(fields["VmRSS"].split()[0]) * 1024, files, int(fields["Threads"]), established

    def stop(self):
        self.process.terminate()
        ended = self.process.wait(60)
        self.directory.cleanup()
        return ended


def grid(draw, side=6):
    axis = list(range(side))
    heights = [[round(draw.gauss(0, 3) + 0.4 * i - 0.2 * j, 4) for j in axis] for i in axis]
    return {"type": "grid", "u": axis, "v": axis, "z": heights}


class Client(threading.Thread):
    """One of the plant's clients: does this and that until the end."""

    def __init__(self, server, seed, end, counts):
        super().__init__(daemon=True)
        self.server, self.draw, self.end, self.counts = server, random.Random(seed), end, counts
        self.fault = None

    def run(self):
        try:
            while time.monotonic() < self.end:
                self.round()
        except Exception as fault:  # a client that fell is told at the end
            self.fault = f"{type(fault).__name__}: {fault}"

    def ask(self, method, path, body=None, headers=None, keep=None, expected=()):
        status, head, text = self.server.call(method, path, body, headers, keep)
        name = f"{method} {status}"
        with self.counts["lock"]:
            self.counts[name] = self.counts.get(name, 0) + 1
        if status == 500 or (expected and status not in expected):
            raise RuntimeError(f"{method} {path}: {status} {text[:300]!r}")
        return status, head, text

    def round(self):
        """A gear from its first measurement to the end of its job."""
        keep = http.client.HTTPConnection("127.0.0.1", self.server.port, timeout=120)
        try:
            job = self.ask("POST", "/v1/jobs", {"name": f"wheel {self.draw.random()}"}, keep=keep, expected=(201,))[1]["location"]
            model = {"type": "polynomial", "degree": [2, 2]}
            for number in range(1, self.draw.randint(2, 5)):
                body = {"nodes": grid(self.draw), "model": model, "operator": "J. Doe"}
                key = {"Idempotency-Key": f"{job}-{number}"}
                for _ in range(2):
                    self.ask("POST", f"{job}/iterations", body, key, keep, (201,))
                self.ask("POST", f"{job}/iterations/{number}/fits", {"model": {"type": "polynomial", "degree": [1, 1]}}, keep=keep, expected=(201,))
                self.ask("PATCH", f"{job}/iterations/{number}", {"decision": "remachine"}, keep=keep, expected=(200,))
            for path in ["/v1/jobs?limit=5", f"{job}/trace", f"{job}/iterations/1", f"{job}/iterations/1/nodes", "/metrics"]:
                self.ask("GET", path, keep=keep, expected=(200,))
            self.draw.choice([self.stream, self.watch, self.listen, self.leave, self.refused])(job)
            if self.draw.random() < 0.5:
                self.purge(job)
            verdict = json.loads(self.ask("GET", f"/v1/audit/verify?job={job.rsplit('/', 1)[1]}", keep=keep, expected=(200,))[2])
            if not verdict["intact"]:
                raise RuntimeError(f"{job}: {verdict}")
        finally:
            keep.close()

    def stream(self, job):
        spec = {"model": {"type": "polynomial", "degree": [1, 1]}}
        stream = self.ask("POST", f"{job}/streams", spec, expected=(201,))[1]["location"]
        for sequence in range(1, 6):
            self.ask("POST", f"{stream}/nodes", {"sequence": sequence, "nodes": grid(self.draw, 3)}, expected=(200,))
        end = self.draw.choice([("POST", f"{stream}/finish", {}, (201,)), ("DELETE", stream, None, (204,))])
        self.ask(*end[:3], expected=end[3])

    def watch(self, job):
        """Has an iteration with progress, or leaves before it is there."""
        body = {"nodes": grid(self.draw, 12), "model": {"type": "polynomial", "degree": [2, 2]}, "estimator": {"type": "lp", "p": 1.5}}
        text = json.dumps(body)
        head = f"POST {job}/iterations HTTP/1.1\r\nHost: localhost\r\nAccept: text/event-stream\r\nContent-Type: application/json\r\n"
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=60) as stream:
            stream.sendall(f"{head}Content-Length: {len(text)}\r\n\r\n{text}".encode())
            answer = b""
            while self.draw.random() > 0.1 and b"event: result" not in answer:
                piece = stream.recv(1 << 16)
                if not piece or b"event: problem" in answer:
                    raise RuntimeError(f"no result: {answer[-300:]!r}")
                answer += piece

    def listen(self, job):
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=30) as stream:
            stream.sendall(f"GET {job}/events HTTP/1.1\r\nHost: localhost\r\nAccept: text/event-stream\r\n\r\n".encode())
            text = b""
            while b"event: decision" not in text:
                piece = stream.recv(1 << 16)
                if not piece:
                    raise RuntimeError("the events ended")
                text += piece

    def leave(self, _job):
        """Declares a body and goes, or asks for a file and goes."""
        with socket.create_connection(("127.0.0.1", self.server.port), timeout=30) as stream:
            length = self.draw.choice([1000, 1 << 20])
            head = f"POST /v1/fits HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n"
            stream.sendall(head.encode() + b" " * self.draw.randint(0, 900))

    def refused(self, job):
        for body in [b"{", b"[]", b'{"nodes":1}']:
            self.ask("POST", f"{job}/iterations", body, expected=(400, 422))
        self.ask("GET", "/v1/jobs/0190b0de-0000-7000-8000-000000000000", expected=(404,))

    def purge(self, job):
        self.ask("GET", f"{job}/archive", expected=(200,))
        self.ask("POST", f"{job}/purge", {"reason": "soak"}, expected=(200,))


def judge(levels):
    """What rose, of the four."""
    rest = levels[len(levels) // 5:]
    quarter = max(len(rest) // 4, 1)
    rose = []
    for k, (name, unit, slack) in enumerate([("memory", MIB, 16), ("files", 1, 8), ("threads", 1, 8), ("connections", 1, 8)]):
        values = [level[k] / unit for level in rest]
        first, last = statistics.median(values[:quarter]), statistics.median(values[-quarter:])
        print(f"{name:12} first {first:9.1f}  last {last:9.1f}  greatest {max(values):9.1f}")
        if last > 1.1 * first + (slack if unit == 1 else 0) and last - first > slack:
            rose.append(name)
    return rose


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("program")
    options.add_argument("--minutes", type=float, default=5)
    options.add_argument("--clients", type=int, default=6)
    options.add_argument("--extra", action="append", default=[], help="an option of the server")
    options = options.parse_args()
    server = Server(options.program, options.extra)
    begun = time.monotonic()
    end, counts = begun + 60 * options.minutes, {"lock": threading.Lock()}
    clients = [Client(server, seed, end, counts) for seed in range(options.clients)]
    for client in clients:
        client.start()
    levels = []
    pause = min(5.0, 60 * options.minutes / 60)
    while time.monotonic() < end and all(client.fault is None for client in clients):
        time.sleep(pause)
        levels.append(server.level())
    for client in clients:
        client.join(150)
    faults = [client.fault or "it hangs" for client in clients if client.fault or client.is_alive()]
    del counts["lock"]
    for name in sorted(counts):
        print(f"{name:12} {counts[name]}")
    rose = judge(levels)
    ended = server.stop()
    print(f"{sum(counts.values())} requests in {time.monotonic() - begun:.0f} s, {len(levels)} looks")
    for fault in faults:
        print(f"a client fell: {fault}")
    for name in rose:
        print(f"{name} rises")
    sys.exit(bool(faults or rose or ended))


if __name__ == "__main__":
    main()
