#!/usr/bin/env python3
"""Verifies a chain of the audit: entries as GET /v1/jobs/{job_id}/audit answers them (pages one after the other).

Prints the number of entries and the head, or the first number at fault. SEALS is a file of seals, kept elsewhere, as
--audit-seal-file has them; what it has of the chain must agree. docs/reference/audit.md has the layout. (Signatures are checked
by `flankfit audit verify`.)
"""
import argparse
import hashlib
import json
import sys
import uuid


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


def root(leaves):
    """The Merkle tree of RFC 6962 over leaves that are digested already."""
    if len(leaves) < 2:
        return leaves[0] if leaves else hashlib.sha256().digest()
    left = 1 << (len(leaves) - 1).bit_length() - 1
    return hashlib.sha256(b"\1" + root(leaves[:left]) + root(leaves[left:])).digest()


def leaf(head):
    data = uuid.UUID(head["chain"]).bytes + head["number"].to_bytes(8, "big") + bytes.fromhex(head["sha256"])
    return hashlib.sha256(b"\0" + data).digest()


def key_of_tenant(tenant):
    """The id of the tenant's own chain, of version 8."""
    data = bytearray(sha256("flankfit audit 1", tenant)[:16])
    data[6], data[8] = data[6] & 0x0F | 0x80, data[8] & 0x3F | 0x80
    return uuid.UUID(bytes=bytes(data))


def sealed(tenant, job, seals):
    """What the seals of a tenant have of a chain: digests by numbers."""
    own = uuid.UUID(job) if job else key_of_tenant(tenant)
    found, last = {}, (0, sha256("flankfit seals 1", tenant))
    for seal in (seal for seal in seals if seal["tenant"] == tenant):
        previous = bytes.fromhex(seal["previous"])
        digest = sha256(previous, tenant, seal["number"], seal["at"], seal["heads"], bytes.fromhex(seal["root"]))
        sound = digest.hex() == seal["sha256"] and root([leaf(head) for head in seal["chains"]]).hex() == seal["root"]
        if not sound or (seal["number"] == last[0] + 1 and previous != last[1]):
            sys.exit(f"seal {seal['number']} is not as it was made")
        last = seal["number"], digest
        found.update((head["number"], head["sha256"]) for head in seal["chains"] if uuid.UUID(head["chain"]) == own)
    return found


def verify(tenant, job, entries, seals=()):
    told = sealed(tenant, job, seals)
    head = sha256("flankfit audit 1", tenant, job)
    nameless, first, unnamed = b"", None, 0
    for number, entry in enumerate(entries, 1):
        own = sha256(bytes.fromhex(entry["previous"]), number, entry["id"], entry["at"], entry.get("actor", ""),
                     entry["action"], entry["target"], entry.get("request_id"), entry.get("peer"),
                     contents(entry["contents"]), entry["outcome"])
        if "actor" not in entry:
            # a purge took the name away, and has a digest of what is left of such entries
            whole = bytes.fromhex(entry["sha256"])
            nameless, first, own = nameless + field(own) + field(whole), first or number, whole
            unnamed += 1
        if entry["number"] != number or own.hex() != entry["sha256"]:
            return f"{number} entry"
        if entry["previous"] != head.hex():
            return f"{number} link"
        if told.pop(number, own.hex()) != own.hex():
            return f"{number} seal"
        if "entries" in entry["contents"]:
            if hashlib.sha256(nameless).hexdigest() != entry["contents"]["entries"]:
                return f"{number} content"
            nameless, first, unnamed = b"", None, 0
        head = own
    if first:
        # a purge takes the name from every entry: where none has one, its own is missing
        return f"{len(entries) + 1 if unnamed == len(entries) else first} entry"
    if told:
        return f"{len(entries) + 1} entry"
    return f"intact {len(entries)} {head.hex() if entries else '-'}"


if __name__ == "__main__":
    lines = __doc__.split("\n", 2)
    reader = argparse.ArgumentParser(description=lines[0], epilog=lines[2], formatter_class=argparse.RawTextHelpFormatter)
    reader.add_argument("--against", metavar="SEALS", help="a file of seals, kept elsewhere")
    reader.add_argument("tenant", metavar="TENANT")
    reader.add_argument("job", metavar="JOB_ID", help='"" for the chain of the tenant itself')
    reader.add_argument("pages", metavar="PAGE", nargs="*", help="a page of entries as it was answered")
    arguments = reader.parse_args()
    try:
        seals = [json.loads(line) for line in open(arguments.against)] if arguments.against else []
        entries = [entry for name in arguments.pages for entry in json.load(open(name))["items"]]
        found = verify(arguments.tenant, arguments.job, entries, seals)
    except (OSError, ValueError, KeyError, TypeError) as error:
        reader.exit(2, f"not found out: {type(error).__name__}: {error}\n")
    print(found)
    sys.exit(not found.startswith("intact"))
