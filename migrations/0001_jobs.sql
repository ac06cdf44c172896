-- Gear jobs. Times are fixed-width RFC 3339 in UTC, ids are UUIDv7 in 16 bytes (their order is the order of creation),
-- gear and tags are JSON documents checked at the door.
CREATE TABLE jobs (
    seq           INTEGER PRIMARY KEY,
    id            BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    name          TEXT    NOT NULL,
    part_number   TEXT,
    serial_number TEXT,
    machine       TEXT,
    gear          TEXT,
    tags          TEXT    NOT NULL,
    version       INTEGER NOT NULL CHECK (version >= 1),
    created_at    TEXT    NOT NULL CHECK (length(created_at) = 27),
    updated_at    TEXT    NOT NULL CHECK (length(updated_at) = 27)
) STRICT;
