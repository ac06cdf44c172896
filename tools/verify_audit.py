#!/usr/bin/env python3
"""Verifies the chain of a tenant: pages of GET /v1/audit, one after the other.

Prints the number of entries that are sealed, or the first number at fault. SEALS is a file of seals, kept elsewhere, as
--audit-seal-file has them; ARCHIVE is that of a job, as GET /v1/jobs/{job_id}/archive has it: its rows must be those that its
entries have digests of, and none may be missing. docs/reference/audit.md has the layout. (Signatures are checked by
`flankfit audit verify`.)
"""
import argparse
import hashlib
import json
import sys

# columns of bytes, which an archive has in hexadecimal digits
BYTES = ("data", "input_sha256", "sha256")
# the number of columns that name a row
KEYS = {"purges": 0, "fits": 2, "fit_choices": 2, "decisions": 2, "records": 2, "streams": 2, "stream_blocks": 2, "stream_states": 2}


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


def digest(tenant, entry):
    return sha256(entry["id"], tenant, entry.get("job_id"), entry["at"], entry["action"], entry["subject"],
                  entry.get("request_id"), entry.get("peer"), contents(entry["contents"]), bytes.fromhex(entry["who"]))


def sealed(tenant, seals):
    """What the seals of a tenant have of its chain: digests by numbers."""
    found, last = {}, (0, sha256("flankfit seals 2", tenant))
    for seal in (seal for seal in seals if seal["tenant"] == tenant):
        previous = bytes.fromhex(seal["previous"])
        own = sha256(previous, tenant, seal["number"], seal["at"], seal["last_entry"], bytes.fromhex(seal["last_sha256"]))
        if own.hex() != seal["sha256"] or (seal["number"] == last[0] + 1 and previous != last[1]):
            sys.exit(f"seal {seal['number']} is not as it was made")
        last = seal["number"], own
        found[seal["last_entry"]] = seal["last_sha256"]
    return found


def verify(tenant, entries, seals=()):
    told = sealed(tenant, seals)
    head = sha256("flankfit audit 2", tenant)
    chain = sorted((entry for entry in entries if "number" in entry), key=lambda entry: entry["number"])
    for number, entry in enumerate(chain, 1):
        head = sha256(head, number, digest(tenant, entry))
        actor = "salt" not in entry or sha256(bytes.fromhex(entry["salt"]), entry.get("actor", "")).hex() == entry["who"]
        if entry["number"] != number or head.hex() != entry["sha256"] or not actor:
            return f"{number} entry"
        if told.pop(number, head.hex()) != head.hex():
            return f"{number} seal"
    if told:
        return f"{len(chain) + 1} entry"
    return f"intact {len(chain)} {head.hex() if chain else '-'}"


def rows(entries, lines):
    """The first row of the archive of a job that is missing, or not the one of its entries."""
    first, lines = json.loads(next(lines, ""))["job"]["job"], list(lines)
    entries = [entry for entry in entries if entry.get("job_id") == first]
    deleted = {entry["subject"].rsplit("/", 1)[1] for entry in entries if entry["action"] == "stream.delete"}
    told, found = {}, set()
    for entry in entries:
        for name, value in entry["contents"].items():
            told.setdefault(name, []).append((bytes.fromhex(entry.get("salt", "")), value))
    versions, unfinished = {}, set()
    for line in lines:
        (table, row), = json.loads(line).items()
        if table in ("end", "archive", "audit"):
            continue
        values = [str(value).lower() if isinstance(value, bool) else value for value in row.values()]
        name = "/".join([table] + [str(value) for value in values[:KEYS.get(table, 1)]])
        columns = [part for key, value in zip(row, values)
                   for part in (key, bytes.fromhex(value) if key in BYTES else value)]
        found.add(name)
        if table in ("jobs", "streams"):
            versions[name.rsplit("/", 1)[0]] = row["version"]
        if table == "streams" and "iteration" not in row:
            unfinished.add(row["id"])
        # many events follow from other rows
        if any(sha256(salt, table, *columns).hex() != value for salt, value in told.get(name, [])) \
                or (name not in told and table != "events"):
            return name
    for name in sorted(told.keys() - found):
        table, (key, _, last) = name.split("/")[0], name.rpartition("/")
        stream = key.rpartition("/")[2]
        if table in ("jobs", "streams"):
            there = versions.get(key, 0) >= int(last) or (key not in versions and stream in deleted)
        elif table in ("stream_blocks", "stream_states"):
            later = table == "stream_states" and any(
                other.startswith(key + "/") and int(other.rpartition("/")[2]) > int(last) for other in told)
            there = stream not in unfinished or later
        else:
            there = False
        if not there:
            return name
    return None


if __name__ == "__main__":
    lines = __doc__.split("\n", 2)
    reader = argparse.ArgumentParser(description=lines[0], epilog=lines[2], formatter_class=argparse.RawTextHelpFormatter)
    reader.add_argument("--against", metavar="SEALS", help="a file of seals, kept elsewhere")
    reader.add_argument("--archive", metavar="ARCHIVE", help="the archive of a job that was not purged")
    reader.add_argument("tenant", metavar="TENANT")
    reader.add_argument("pages", metavar="PAGE", nargs="*", help="a page of entries as it was answered")
    arguments = reader.parse_args()
    try:
        seals = [json.loads(line) for line in open(arguments.against)] if arguments.against else []
        entries = [entry for name in arguments.pages for entry in json.load(open(name))["items"]]
        found = verify(arguments.tenant, entries, seals)
        wrong = rows(entries, open(arguments.archive)) if arguments.archive else None
    except (OSError, ValueError, KeyError, TypeError) as error:
        reader.exit(2, f"not found out: {type(error).__name__}: {error}\n")
    print(f"{wrong} row" if wrong else found)
    sys.exit(wrong is not None or not found.startswith("intact"))
