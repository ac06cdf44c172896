#!/usr/bin/env python3
"""The aims of several servers, as ratios measured in turns on one machine.

    tools/plant_ratios.py PROGRAM [NAME…]

PROGRAM is a built flankfit. Names: keys, tls, traces, replicas, stream, events, restart, stored; without one all of them. Needs
wrk, openssl and PostgreSQL (FLANKFIT_POSTGRES_BIN, or /usr/lib/postgresql); as root PostgreSQL runs as `nobody`.
`--rounds N` and `--seconds S` say how long.
"""

import argparse
import concurrent.futures
import glob
import http.client
import http.server
import json
import math
import os
import re
import shutil
import signal
import statistics
import subprocess
import tempfile
import threading
import time

LUA = """
wrk.method = "POST"
wrk.headers["Content-Type"] = "application/json"
local key = os.getenv("RATIO_KEY")
if key then wrk.headers["Authorization"] = "Bearer " .. key end
local file = io.open(os.getenv("RATIO_BODY"), "rb")
wrk.body = file:read("*a")
file:close()
done = function(summary, latency, requests)
  local e = summary.errors
  io.write(string.format("RATE %f %d\\n", summary.requests / summary.duration * 1e6,
    e.connect + e.read + e.write + e.status + e.timeout))
end
"""


def grid(nu, nv):
    u = [30 + 4 * i / (nu - 1) for i in range(nu)]
    v = [20 * j / (nv - 1) for j in range(nv)]
    z = [[round(0.01 * a - 0.002 * b + 1e-3 * math.sin(3 * a + b), 6) for b in v] for a in u]
    return {"nodes": {"type": "grid", "u": u, "v": v, "z": z}, "model": {"type": "polynomial", "degree": [3, 3]}}


def scattered(count):
    u = [round(30 + 4 * math.modf(0.37 * i + 0.1)[0], 6) for i in range(count)]
    v = [round(20 * math.modf(0.71 * i + 0.2)[0], 6) for i in range(count)]
    z = [round(0.01 * a - 0.002 * b + 1e-3 * math.sin(3 * a + b), 6) for a, b in zip(u, v)]
    return {"nodes": {"type": "scattered", "u": u, "v": v, "z": z}, "model": {"type": "polynomial", "degree": [3, 3]}}


class Place:
    """A folder with everything that runs; all of it ends with it."""

    def __init__(self, program):
        self.program = os.path.abspath(program)
        self.folder = tempfile.mkdtemp(prefix="ffratio")
        os.chmod(self.folder, 0o755)
        self.running = []
        self.cluster = None
        self.databases = 0
        with open(self.path("post.lua"), "w") as file:
            file.write(LUA)

    def path(self, name):
        return os.path.join(self.folder, name)

    def body(self, name, request):
        with open(self.path(name), "w") as file:
            json.dump(request, file)
        return self.path(name)

    def server(self, url, *arguments, cpu=None):
        """Starts a server: its process and address."""
        command = [self.program, "serve", "--bind", "127.0.0.1:0", "--database-url", url, "--log-format", "json"]
        command += list(arguments)
        if cpu is not None:
            command = ["taskset", "-c", str(cpu)] + command
        log = open(self.path(f"log{len(self.running)}"), "w+")
        process = subprocess.Popen(command, stderr=log, stdout=subprocess.DEVNULL)
        self.running.append(process)
        for _ in range(400):
            time.sleep(0.05)
            with open(log.name) as file:
                found = re.search(r'"address":"(127\.0\.0\.1:[1-9]\d*)"', file.read())
            if found:
                return process, found.group(1)
            assert process.poll() is None, open(log.name).read()
        raise SystemExit("the server does not say where it listens")

    def sqlite(self):
        self.databases += 1
        return f"sqlite://{self.path(f'd{self.databases}.db')}"

    def shell(self, script, **how):
        programs = os.environ.get("FLANKFIT_POSTGRES_BIN") or sorted(glob.glob("/usr/lib/postgresql/*/bin"))[-1]
        command = ["sh", "-c", script]
        if os.geteuid() == 0:
            command = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"] + command
        return subprocess.run(command, cwd=self.cluster, env={**os.environ, "BIN": programs}, check=True,
                              stdout=subprocess.PIPE, **how).stdout

    def postgres(self):
        """A new database on a cluster of its own, which syncs what it commits."""
        if self.cluster is None:
            self.cluster = self.path("pg")
            os.mkdir(self.cluster)
            if os.geteuid() == 0:
                os.chown(self.cluster, 65534, 65534)
            self.shell("$BIN/initdb -D data -A trust -U owner -E UTF8 --no-locale >log && "
                       "printf \"listen_addresses=''\\nunix_socket_directories='$PWD'\\n\" >>data/postgresql.conf && "
                       "$BIN/pg_ctl -D data -l log -w start >log2")
        self.databases += 1
        self.shell(f"$BIN/createdb -h $PWD -U owner d{self.databases}")
        return f"postgres://owner@localhost/d{self.databases}?host={self.cluster}"

    def end(self):
        for process in self.running:
            process.send_signal(signal.SIGKILL)
            process.wait()
        self.running = []

    def close(self):
        self.end()
        if self.cluster:
            self.shell("$BIN/pg_ctl -D data -m immediate stop >log2")
        shutil.rmtree(self.folder)


def wrk(place, address, path, body, seconds, key=None, scheme="http", connections=8):
    """Requests a second, every one of them answered with success."""
    environment = {**os.environ, "RATIO_BODY": body}
    environment.pop("RATIO_KEY", None)
    if key:
        environment["RATIO_KEY"] = key
    said = subprocess.run(["wrk", "-t1", f"-c{connections}", f"-d{seconds}s", "--timeout", "30s", "-s",
                           place.path("post.lua"), f"{scheme}://{address}{path}"],
                          env=environment, capture_output=True, text=True)
    found = re.search(r"RATE ([\d.]+) (\d+)", said.stdout)
    assert found and found.group(2) == "0", said.stdout + said.stderr
    return float(found.group(1))


def post(address, path, request, headers=None):
    """Status and answer."""
    connection = http.client.HTTPConnection(address, timeout=60)
    try:
        connection.request("POST", path, json.dumps(request), {"Content-Type": "application/json", **(headers or {})})
        answer = connection.getresponse()
        return answer.status, json.loads(answer.read() or b"null")
    finally:
        connection.close()


def created(address, path, request):
    status, answer = post(address, path, request)
    assert status == 201, answer
    return answer


def in_turns(name, aim, rounds, one, other):
    """Ratios of one to the other, measured one after the other, each first in every second round."""
    ratios, ones, others = [], [], []
    for turn in range(rounds):
        if turn % 2:
            b, a = other(), one()
        else:
            a, b = one(), other()
        ones.append(a)
        others.append(b)
        ratios.append(a / b)
    ratios.sort()
    print(f"{name}: {statistics.median(ones):.0f} : {statistics.median(others):.0f}, median of the ratios "
          f"{statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f}, {rounds} rounds); aim {aim}",
          flush=True)


def keys(place, rounds, seconds):
    _, open_ = place.server(place.sqlite(), "--auth", "off")
    url = place.sqlite()
    made = subprocess.run([place.program, "keys", "create", "--tenant", "ratio", "--role", "engineer", "--database-url", url],
                          check=True, capture_output=True, text=True)
    key = re.search(r"ffk_\S+", made.stdout).group()
    _, closed = place.server(url)
    status, _ = post(closed, "/v1/fits", grid(5, 9))
    assert status == 401
    body = place.body("fit.json", grid(5, 9))
    in_turns("fits/s with a stored key : open", ">= 0.97", rounds,
             lambda: wrk(place, closed, "/v1/fits", body, seconds, key=key),
             lambda: wrk(place, open_, "/v1/fits", body, seconds))


def tls(place, rounds, seconds):
    certificate, key = place.path("cert.pem"), place.path("key.pem")
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes",
                    "-keyout", key, "-out", certificate, "-days", "2", "-subj", "/CN=localhost",
                    "-addext", "subjectAltName=DNS:localhost"], check=True, capture_output=True)
    _, plain = place.server(place.sqlite(), "--auth", "off")
    _, secure = place.server(place.sqlite(), "--auth", "off", "--tls-cert", certificate, "--tls-key", key)
    body = place.body("fit.json", grid(5, 9))
    in_turns("fits/s TLS : plain, kept alive", ">= 0.8", rounds,
             lambda: wrk(place, secure, "/v1/fits", body, seconds, scheme="https"),
             lambda: wrk(place, plain, "/v1/fits", body, seconds))


class Sink(http.server.BaseHTTPRequestHandler):
    """Takes spans as a collector does, and throws them away."""

    protocol_version = "HTTP/1.1"
    taken = 0

    def do_POST(self):
        Sink.taken += len(self.rfile.read(int(self.headers["Content-Length"])))
        self.send_response(200)
        self.send_header("Content-Length", "0")
        self.end_headers()

    def log_message(self, *_):
        pass


def traces(place, rounds, seconds):
    """One request in a hundred is traced, as by default."""
    sink = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Sink)
    threading.Thread(target=sink.serve_forever, daemon=True).start()
    _, off = place.server(place.sqlite(), "--auth", "off")
    _, traced = place.server(place.sqlite(), "--auth", "off", "--otlp-endpoint",
                             f"http://127.0.0.1:{sink.server_address[1]}", "--otlp-sample", "0.01")
    body = place.body("fit.json", grid(5, 9))
    in_turns("fits/s with traces at 1 % : off", ">= 0.97", rounds,
             lambda: wrk(place, traced, "/v1/fits", body, seconds),
             lambda: wrk(place, off, "/v1/fits", body, seconds))
    time.sleep(3)
    sink.shutdown()
    assert Sink.taken > 0, "no spans came"


def replicas(place, rounds, seconds):
    """Fits so long that whoever asks for them takes little of the cores."""
    url = place.postgres()
    addresses = [place.server(url, "--auth", "off", "--workers", "1", cpu=cpu)[1] for cpu in (0, 1)]
    request = grid(5, 9)
    request["estimator"] = {"type": "least_trimmed_squares"}
    body = place.body("long.json", request)

    def both():
        with concurrent.futures.ThreadPoolExecutor() as pool:
            return sum(pool.map(lambda at: wrk(place, at, "/v1/fits", body, seconds, connections=2), addresses))

    turn = iter(range(10**6))
    in_turns("fits/s of 2 replicas, a core each : 1", ">= 1.9", rounds, both,
             lambda: wrk(place, addresses[next(turn) % 2], "/v1/fits", body, seconds, connections=2))


def nodes_of(first, count):
    places = range(first, first + count)
    u = [30 + 4 * math.modf(0.37 * i)[0] for i in places]
    v = [20 * math.modf(0.71 * i)[0] for i in places]
    z = [0.01 * a - 0.002 * b + 1e-3 * math.sin(3 * a + b) for a, b in zip(u, v)]
    return {"type": "scattered", "u": u, "v": v, "z": z}


def stream(place, rounds, seconds):
    """Every fifth block comes to the other replica, which has not seen the four before it."""
    url = place.postgres()
    addresses = [place.server(url, "--auth", "off")[1] for _ in range(2)]
    job = created(addresses[0], "/v1/jobs", {"name": "ratio"})["id"]
    spec = {"model": {"type": "polynomial", "degree": [3, 3], "basis": "chebyshev"},
            "domain": {"u": [30, 34], "v": [0, 20]}}
    of = created(addresses[0], f"/v1/jobs/{job}/streams", spec)["id"]
    kept = [http.client.HTTPConnection(address, timeout=60) for address in addresses]
    right, wrong = [], []
    for number in range(40 * rounds * 5):
        at = number // 5 % 2
        request = json.dumps({"sequence": number + 1, "nodes": nodes_of(5 * number, 5)})
        begun = time.perf_counter()
        kept[at].request("POST", f"/v1/streams/{of}/nodes", request, {"Content-Type": "application/json"})
        answer = kept[at].getresponse()
        text = answer.read()
        taken = time.perf_counter() - begun
        assert answer.status == 200, text
        if number >= 50:
            (right if number % 5 else wrong).append(taken)
    one, other = statistics.median(wrong), statistics.median(right)
    print(f"stream block at the wrong replica : the right one: {1e3 * one:.2f} ms : {1e3 * other:.2f} ms = "
          f"{one / other:.2f} (medians of {len(wrong)} and {len(right)}); aim <= 3", flush=True)


def heard(place, url, count, *arguments):
    """Seconds from the answer to an iteration at one replica to its event at the other."""
    _, writes = place.server(url, "--auth", "off", *arguments)
    _, hears = place.server(url, "--auth", "off", *arguments)
    job = created(writes, "/v1/jobs", {"name": "ratio"})["id"]
    listener = http.client.HTTPConnection(hears, timeout=30)
    listener.request("GET", f"/v1/jobs/{job}/events")
    events, times, ends = listener.getresponse(), [], []
    got = threading.Event()

    def listen():
        while True:
            line = events.fp.readline()
            if not line:
                return
            if line.startswith(b"id:"):
                times.append(time.perf_counter())
                got.set()

    threading.Thread(target=listen, daemon=True).start()
    time.sleep(0.3)
    for _ in range(count):
        got.clear()
        created(writes, f"/v1/jobs/{job}/iterations", grid(5, 9))
        ends.append(time.perf_counter())
        assert got.wait(20), "no event"
        time.sleep(0.02 + 0.05 * ((len(ends) * 0.618) % 1))
    return sorted(max(0.0, time_ - end) for time_, end in zip(times, ends))


def events(place, rounds, seconds):
    url = place.postgres()
    for name, aim, count, arguments in [
        ("with NOTIFY", 0.1, 40 * rounds, []),
        # a direct address behind which there is nobody: nothing is heard, each looks by itself
        ("without", 2.5, 8 * rounds, ["--migrate", "check", "--database-direct-url", "postgres://owner@127.0.0.1:1/none"]),
    ]:
        delays = heard(place, url, count, *arguments)
        p99 = delays[min(len(delays) - 1, math.ceil(0.99 * len(delays)) - 1)]
        print(f"event across replicas {name}: p50 {delays[len(delays) // 2]:.3f} s, p99 {p99:.3f} s of {count}; "
              f"aim p99 {aim} s", flush=True)
        place.end()


def restart(place, rounds, seconds):
    """What writers see of a restart of PostgreSQL that takes less than the patience."""
    url = place.postgres()
    _, address = place.server(url, "--auth", "off")
    jobs = [created(address, "/v1/jobs", {"name": "ratio"})["id"] for _ in range(8)]
    over, errors, longest, lock = threading.Event(), [], [0.0], threading.Lock()

    def write(job):
        while not over.is_set():
            begun = time.perf_counter()
            status, answer = post(address, f"/v1/jobs/{job}/iterations", grid(5, 9))
            with lock:
                longest[0] = max(longest[0], time.perf_counter() - begun)
                if status != 201:
                    errors.append((status, answer))

    writers = [threading.Thread(target=write, args=(job,)) for job in jobs]
    for writer in writers:
        writer.start()
    beyond, downs = [], []
    for _ in range(max(3, rounds)):
        time.sleep(2)
        with lock:
            longest[0] = 0.0
        begun = time.perf_counter()
        place.shell("$BIN/pg_ctl -D data -l log -m fast -w restart >log2")
        down = time.perf_counter() - begun
        time.sleep(2)
        with lock:
            beyond.append(longest[0] - down)
        downs.append(down)
    over.set()
    for writer in writers:
        writer.join()
    print(f"restart of PostgreSQL ({statistics.median(downs):.2f} s, the longest {max(downs):.2f}) as a writer sees it: "
          f"+ {statistics.median(beyond):.2f} s, at most + {max(beyond):.2f} s, {len(errors)} errors in {len(downs)}; "
          f"aim + 1 s, no error", flush=True)
    for error in errors[:3]:
        print(error)


def stored(place, rounds, seconds):
    """Iterations of 45 nodes and 16 coefficients, durable, 64 connections, on either store."""
    body = place.body("fit.json", grid(5, 9))
    for name, url in [("SQLite", place.sqlite()), ("PostgreSQL", place.postgres())]:
        _, address = place.server(url, "--auth", "off")
        rates = []
        for _ in range(rounds):
            job = created(address, "/v1/jobs", {"name": "ratio"})["id"]
            rates.append(wrk(place, address, f"/v1/jobs/{job}/iterations", body, seconds, connections=64))
        rates.sort()
        print(f"iterations/s stored, {name}: {statistics.median(rates):.0f} ({rates[0]:.0f} to {rates[-1]:.0f})", flush=True)
        place.end()


ALL = {of.__name__: of for of in (keys, tls, traces, replicas, stream, events, restart, stored)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("names", nargs="*", choices=[*ALL, []])
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--seconds", type=int, default=3)
    given = parser.parse_args()
    place = Place(given.program)
    try:
        for name in given.names or ALL:
            ALL[name](place, given.rounds, given.seconds)
            place.end()
    finally:
        place.close()


if __name__ == "__main__":
    main()
