#!/usr/bin/env python3
"""Iterations stored a second, beside a service that a user would write instead, measured in turns on one machine.

    tools/compare_fastapi.py PROGRAM [--rounds 5] [--seconds 5]

PROGRAM is a built flankfit. The other one is `tools/peers/fastapi_store.py` by uvicorn with a worker a core: it fits 45 nodes by
numpy, stores one row and syncs it. 64 connections each. Needs wrk, and the Python that runs this fastapi, uvicorn and numpy.
"""

import argparse
import os
import pathlib
import signal
import socket
import statistics
import subprocess
import sys
import time

from plant_ratios import Place, created, grid, in_turns, wrk

PEERS = pathlib.Path(__file__).parent / "peers"
CONNECTIONS = 64


def fastapi(place):
    """Starts the other service: its process, which leads those of its workers, and its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-m", "uvicorn", "--app-dir", str(PEERS), "fastapi_store:app", "--port", str(port),
               "--workers", str(os.cpu_count()), "--log-level", "error", "--no-access-log"]
    # a thread each: several fits at a time would otherwise want the same cores
    quiet = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    process = subprocess.Popen(command, env={**os.environ, **quiet, "STORE": place.path("peer.db")}, start_new_session=True)
    for _ in range(400):
        time.sleep(0.1)
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            return process, f"127.0.0.1:{port}"
        except OSError:
            pass
    os.killpg(process.pid, signal.SIGKILL)
    raise SystemExit("uvicorn does not start")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=int, default=5)
    given = parser.parse_args()
    place = Place(given.program)
    process, theirs = fastapi(place)
    try:
        _, ours = place.server(place.sqlite(), "--auth", "off")
        body = place.body("measured.json", grid(5, 9))
        job = created(ours, "/v1/jobs", {"name": "ratio"})["id"]

        def rate(address, path):
            return wrk(place, address, path, body, given.seconds, connections=CONNECTIONS)

        # both have their files and caches
        for address, path in ((ours, f"/v1/jobs/{job}/iterations"), (theirs, "/v1/jobs/1/iterations")):
            rate(address, path)
        in_turns("iterations/s, flankfit : FastAPI", ">= 2.6", given.rounds,
                 lambda: rate(ours, f"/v1/jobs/{job}/iterations"),
                 lambda: rate(theirs, "/v1/jobs/1/iterations"))
        rates = [rate(ours, "/v1/fits") for _ in range(given.rounds)]
        print(f"fits/s of which nothing is stored, for comparison: {statistics.median(rates):.0f}")
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        place.close()


if __name__ == "__main__":
    main()
