-- Answers kept for clients that ask again with the same Idempotency-Key. scope is method and path; the digest is that of the
-- request, so that the same key with another body is told apart.
CREATE TABLE idempotency_keys (
    seq            INTEGER PRIMARY KEY,
    key            TEXT    NOT NULL,
    scope          TEXT    NOT NULL,
    request_sha256 BLOB    NOT NULL CHECK (length(request_sha256) = 32),
    status         INTEGER NOT NULL,
    location       TEXT,
    etag           TEXT,
    body           BLOB    NOT NULL,
    created_at     TEXT    NOT NULL CHECK (length(created_at) = 27),
    UNIQUE (key, scope)
) STRICT;

CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
