#!/usr/bin/env python3
"""Verifies a chain of the audit: entries as GET /v1/jobs/{job_id}/audit answers them (pages one after the other).

    tools/verify_audit.py TENANT JOB_ID page1.json page2.json …      (JOB_ID "" for the chain of the tenant itself)

Prints the number of entries and the head, or the first number at fault. docs/audit.md has the layout.
"""
import hashlib
import json
import sys


def field(value):
    """A field behind its length in 8 bytes; one that is absent has the greatest length and nothing behind it."""
    if value is None:
        return b"\xff" * 8
    value = value if isinstance(value, bytes) else str(value).encode()
    return len(value).to_bytes(8, "big") + value


def sha256(*fields):
    return hashlib.sha256(b"".join(field(value) for value in fields)).digest()


def contents(digests):
    rows = sorted((name.encode(), bytes.fromhex(digest)) for name, digest in digests.items())
    return b"".join(bytes([len(name)]) + name + digest for name, digest in rows)


def verify(tenant, job, entries):
    head = sha256("flankfit audit 1", tenant, job)
    for number, entry in enumerate(entries, 1):
        own = sha256(bytes.fromhex(entry["previous"]), number, entry["id"], entry["at"], entry["actor"],
                     entry["action"], entry["target"], entry.get("request_id"), entry.get("peer"),
                     contents(entry["contents"]), entry["outcome"])
        if entry["number"] != number or own.hex() != entry["sha256"]:
            return f"{number} entry"
        if entry["previous"] != head.hex():
            return f"{number} link"
        head = own
    return f"intact {len(entries)} {head.hex() if entries else '-'}"


if __name__ == "__main__":
    found = verify(sys.argv[1], sys.argv[2], [entry for name in sys.argv[3:] for entry in json.load(open(name))["items"]])
    print(found)
    sys.exit(not found.startswith("intact"))
