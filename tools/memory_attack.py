#!/usr/bin/env python3
"""What a server can be made to hold: the dearest requests one by one, then a mixture of many clients.

    tools/memory_attack.py target/release/flankfit [--only NAME] [--clients 64] [--seconds 30] [--limits]

Starts the program on a database of its own with its default settings (workers as many as processors), sends requests over
127.0.0.1 and reads the peak of its resident memory from /proc (Linux). Prints a line for each attack; with --limits it ends with 1
where a request or the mixture took more than 1 GiB, or unread answers left more than 150 MiB. Standard library only.
"""

import argparse
import gzip
import http.client
import json
import os
import pathlib
import random
import re
import socket
import subprocess
import sys
import tempfile
import threading
import time

MIB = 1 << 20
LIMIT = 32 * MIB  # of a body, by default
EXAMPLES = pathlib.Path(__file__).resolve().parent.parent / "examples" / "requests"


class Server:
    """The program, on a free port and a database in a directory that goes away."""

    def __init__(self, program, extra):
        self.directory = tempfile.TemporaryDirectory()
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        url = f"sqlite://{self.directory.name}/attack.db"
        command = [program, "serve", "--bind", f"127.0.0.1:{self.port}", "--database-url", url, "--log", "error", *extra]
        self.process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        for _ in range(200):
            try:
                return self.ready()
            except OSError:
                time.sleep(0.05)
        raise SystemExit("the server does not start")

    def ready(self):
        if self.get("/readyz")[0] != 200:
            raise OSError("not ready")

    def connection(self, timeout=180):
        return http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)

    def get(self, path):
        connection = self.connection()
        connection.request("GET", path)
        answer = connection.getresponse()
        return answer.status, answer.read()

    def post(self, path, body, headers=None, method="POST", timeout=180):
        """Status and length of the answer."""
        connection = self.connection(timeout)
        try:
            connection.request(method, path, body, {"Content-Type": "application/json", **(headers or {})})
            answer = connection.getresponse()
            length = 0
            while piece := answer.read(MIB):
                length += len(piece)
            return answer.status, length
        except (OSError, http.client.HTTPException) as error:
            return type(error).__name__, 0
        finally:
            connection.close()

    def memory(self, key):
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(rf"{key}:\s+(\d+) kB", status)[1]) * 1024

    def forget_peak(self):
        pathlib.Path(f"/proc/{self.process.pid}/clear_refs").write_text("5")

    def held(self):
        text = self.get("/metrics")[1].decode()
        return int(float(re.search(r"^flankfit_body_memory_bytes (\S+)", text, re.M)[1]))

    def stop(self):
        self.process.terminate()
        self.process.wait(60)
        self.directory.cleanup()


def bomb(length, inside=b" "):
    """A body that unpacks to this length: gzip of one byte over and over."""
    return gzip.compress(inside * (length // len(inside)), 9)


def numbers(count, digits):
    """So many ascending numbers of so many digits, as JSON."""
    return ",".join(f"{(i + 1) / (count + 2):.{digits}f}" for i in range(count))


def curve(count, digits):
    x = numbers(count, digits)
    return f'{{"nodes":{{"type":"curve","x":[{x}],"y":[{x}]}},"model":{{"type":"polynomial","degree":2}}}}'.encode()


def scattered(count):
    draw = random.Random(1)
    column = lambda: ",".join(repr(draw.random()) for _ in range(count))
    nodes = f'"u":[{column()}],"v":[{column()}],"z":[{column()}]'
    return f'{{"nodes":{{"type":"scattered",{nodes}}},"model":{{"type":"polynomial","degree":3}}}}'.encode()


def brief(count):
    """The most numbers in the fewest bytes."""
    ones = "1" + ",1" * (count - 1)
    return f'{{"nodes":{{"type":"curve","x":[{ones}],"y":[{ones}]}},"model":{{"type":"polynomial","degree":0}}}}'.encode()


def export(form, samples=1999):
    surface = json.loads((EXAMPLES / "surface_export.json").read_text())
    return json.dumps({**surface, "format": form, "samples": [samples, samples]}).encode()


def form(rows):
    table = "u,v,z\n" + "".join(f"{i},{i % 997},{i % 31}\n" for i in range(rows))
    spec = '{"model":{"type":"polynomial","degree":2}}'
    parts = f'--x\r\nContent-Disposition: form-data; name="spec"\r\n\r\n{spec}\r\n'
    parts += f'--x\r\nContent-Disposition: form-data; name="nodes"\r\n\r\n{table}\r\n--x--\r\n'
    return parts.encode()


def example(name, **changes):
    return json.dumps({**json.loads((EXAMPLES / f"{name}.json").read_text()), **changes}).encode()


def flank():
    axis = {"axis": "diameter", "values": [187 + 6 * i / 1413 for i in range(1414)]}
    positions = [30 * i / 1413 for i in range(1414)]
    return example("gear_flank", profile=axis, face_width_positions_mm=positions)


def places(count):
    return [[i / count, (i * 7919 % count) / count] for i in range(count)]


def deviations(count):
    points = json.loads((EXAMPLES / "gear_deviations.json").read_text())["points"]
    return example("gear_deviations", points=(points * (count // len(points) + 1))[:count])


PACKED = {"Content-Encoding": "gzip"}
FORM = {"Content-Type": "multipart/form-data; boundary=x"}

# name: path, body (made when it is wanted), headers, method
SINGLE = {
    "million_nodes": ("/v1/fits", lambda: scattered(550_000), {}, "POST"),
    "long_numbers": ("/v1/fits", lambda: curve(800_000, 17), {}, "POST"),
    "brief_numbers": ("/v1/fits", lambda: brief(4_000_000), {}, "POST"),
    "briefest_numbers": ("/v1/fits", lambda: brief(8_000_000), {}, "POST"),
    "packed_numbers": ("/v1/fits", lambda: gzip.compress(curve(800_000, 17), 1), PACKED, "POST"),
    "bomb": ("/v1/fits", lambda: bomb(LIMIT), PACKED, "POST"),
    "bomb_of_lists": ("/v1/curves/evaluate", lambda: bomb(LIMIT, b"[]," * 4096), PACKED, "POST"),
    "bomb_patch": ("/v1/jobs/0190b0de-0000-7000-8000-000000000000", lambda: bomb(LIMIT), PACKED, "PATCH"),
    "form": ("/v1/fits", lambda: form(2_000_000), FORM, "POST"),
    "nested": ("/v1/surfaces/evaluate", lambda: b'{"at":' + b"[" * (31 * MIB), {}, "POST"),
    "points": ("/v1/surfaces/evaluate", lambda: example("surface_evaluate", at=places(800_000)), {}, "POST"),
    "deviations": ("/v1/gears/deviations", lambda: deviations(200_000), {}, "POST"),
    "flank": ("/v1/gears/flank", flank, {}, "POST"),
    "flank_csv": ("/v1/gears/flank", flank, {"Accept": "text/csv"}, "POST"),
    **{
        f"export_{form}": ("/v1/surfaces/export", lambda form=form: export(form), {}, "POST")
        for form in ["stl_text", "stl", "obj", "vtk", "csv_nodes", "csv_elements", "abaqus", "adina"]
    },
}


def singles(server, only):
    worst = 0
    for name, (path, make, headers, method) in SINGLE.items():
        if only and not re.search(only, name):
            continue
        body = make()
        time.sleep(0.3)  # what the one before has freed goes back to the system
        server.forget_peak()
        before, begun = server.memory("VmRSS"), time.monotonic()
        status, length = server.post(path, body, headers, method)
        peak = server.memory("VmHWM")
        worst = max(worst, peak)
        print(
            f"{name:18} body {len(body) / MIB:7.1f} MiB  answer {status} {length / MIB:7.1f} MiB  "
            f"peak {peak / MIB:7.1f} MiB (+{(peak - before) / MIB:.1f}, {(peak - before) / len(body):.2f} of the body)  "
            f"{time.monotonic() - begun:.1f} s",
            flush=True,
        )
    return worst


def unread_answers(server, count=4):
    """Answers that nobody reads: what is held while they wait, and a minute after their clients have gone."""
    body = export("obj")
    head = f"POST /v1/surfaces/export HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
    clients = []
    for _ in range(count):
        stream = socket.socket()
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stream.connect(("127.0.0.1", server.port))
        stream.sendall(head.encode() + body)
        stream.recv(1)
        clients.append(stream)
    print(f"{count} unread answers: {server.memory('VmRSS') / MIB:.1f} MiB resident, {server.held()} bytes held", flush=True)
    for stream in clients:
        stream.close()
    for seconds in (0, 5, 25, 30):
        time.sleep(seconds)
        # nobody asks the server for anything meanwhile
        print(f"  {seconds} s later: {server.memory('VmRSS') / MIB:.1f} MiB resident", flush=True)
    resident = server.memory("VmRSS")
    print(f"  {server.held()} bytes held")
    return resident


def mixture(server, clients, seconds):
    """Many clients of all kinds at once; an honest one among them is timed."""
    fit, stored = curve(100_000, 17), server.post("/v1/jobs", b'{"name":"attack"}')
    assert stored[0] == 201, stored
    jobs = json.loads(server.get("/v1/jobs")[1])["items"]
    place = f"/v1/jobs/{jobs[0]['id']}"
    packed, blank = gzip.compress(scattered(300_000), 1), bomb(LIMIT)
    end, counts, lock = time.monotonic() + seconds, {}, threading.Lock()

    def note(kind, status):
        with lock:
            counts[(kind, status)] = counts.get((kind, status), 0) + 1

    def unread(draw):
        """Asks for much and reads nothing."""
        with socket.socket() as stream:
            stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            stream.connect(("127.0.0.1", server.port))
            body = export(draw.choice(["obj", "stl_text", "vtk"]))
            head = f"POST /v1/surfaces/export HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {len(body)}\r\n\r\n"
            stream.sendall(head.encode() + body)
            time.sleep(max(0.0, min(draw.uniform(1, 20), end - time.monotonic())))
        return "left"

    def slow(draw):
        """Declares much and sends it drop by drop."""
        with socket.socket() as stream:
            stream.connect(("127.0.0.1", server.port))
            head = f"POST /v1/fits HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\nContent-Length: {LIMIT}\r\n\r\n"
            stream.sendall(head.encode())
            stop = min(time.monotonic() + draw.uniform(1, 10), end)
            while time.monotonic() < stop:
                stream.sendall(b" " * MIB)
                time.sleep(0.1)
        return "left"

    attacks = {
        "bomb": lambda _: server.post("/v1/fits", blank, PACKED)[0],
        "bomb_patch": lambda _: server.post(place, blank, PACKED, "PATCH")[0],
        "bomb_keyed": lambda draw: server.post(
            f"{place}/iterations", blank, {**PACKED, "Idempotency-Key": str(draw.random())}
        )[0],
        "fit": lambda _: server.post("/v1/fits", fit)[0],
        "packed": lambda _: server.post("/v1/fits", packed, PACKED)[0],
        "iteration": lambda _: server.post(f"{place}/iterations", fit)[0],
        "nodes": lambda _: server.post(f"{place}/iterations/1/nodes", None, method="GET")[0],
        "export": lambda draw: server.post("/v1/surfaces/export", export(draw.choice(["stl", "obj"]), 500))[0],
        "unread": unread,
        "slow": slow,
    }

    def client(seed):
        draw = random.Random(seed)
        while time.monotonic() < end:
            kind = draw.choice(list(attacks))
            try:
                note(kind, attacks[kind](draw))
            except OSError as error:
                note(kind, type(error).__name__)

    waited = []

    def honest():
        small = (EXAMPLES / "fit_curve.json").read_bytes()
        while time.monotonic() < end:
            begun = time.monotonic()
            status = server.post("/v1/fits", small)[0]
            waited.append(time.monotonic() - begun)
            note("honest", status)
            time.sleep(0.05)

    server.forget_peak()
    threads = [threading.Thread(target=client, args=(seed,)) for seed in range(clients)]
    threads.append(threading.Thread(target=honest))
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    peak = server.memory("VmHWM")
    for (kind, status), count in sorted(counts.items(), key=str):
        print(f"  {kind:12} {status!s:24} {count}")
    waited.sort()
    print(
        f"mixture of {clients} clients, {seconds} s: peak {peak / MIB:.1f} MiB; the honest one waited "
        f"{1e3 * waited[len(waited) // 2]:.0f} ms (median), {1e3 * waited[-1]:.0f} ms (longest) of {len(waited)}"
    )
    time.sleep(1)
    print(f"afterwards: {server.memory('VmRSS') / MIB:.1f} MiB resident, {server.held()} bytes held", flush=True)
    return peak


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--only", help="names of single requests, as a regular expression; `mixture` or `unread` for these alone")
    parser.add_argument("--clients", type=int, default=64)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--limits", action="store_true", help="end with 1 where the promised limits are exceeded")
    parser.add_argument("--serve", default="", help="further arguments of the server")
    arguments = parser.parse_args()
    server = Server(os.path.abspath(arguments.program), arguments.serve.split())
    try:
        worst = singles(server, arguments.only)
        left = unread_answers(server) if arguments.only in (None, "unread") else 0
        peak = mixture(server, arguments.clients, arguments.seconds) if arguments.only in (None, "mixture") else 0
    finally:
        server.stop()
    if arguments.limits and (worst > 1024 * MIB or left > 150 * MIB or peak > 1024 * MIB):
        sys.exit("the limits are exceeded")


if __name__ == "__main__":
    main()
