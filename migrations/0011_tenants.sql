-- Tenants: each job, and with it whatever belongs to it, is one tenant's. Jobs from before are `default`'s. A job stays with its tenant.
ALTER TABLE jobs ADD COLUMN tenant TEXT NOT NULL DEFAULT 'default' CHECK (length(tenant) BETWEEN 1 AND 63);

CREATE INDEX jobs_of_tenant ON jobs (tenant, id);

CREATE TRIGGER jobs_keep_their_tenant BEFORE UPDATE OF tenant ON jobs WHEN NEW.tenant <> OLD.tenant
BEGIN
    SELECT RAISE (ABORT, 'a job stays with its tenant');
END;

-- Answers kept under idempotency keys, by tenant, made anew since the key is another one. Where an answer has the result of a fit in
-- it, which is stored anyway, fit names that, body is what stands before the result, and body_end what stands after it.
CREATE TABLE kept_answers (
    seq            INTEGER PRIMARY KEY,
    tenant         TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    key            TEXT    NOT NULL,
    scope          TEXT    NOT NULL,
    request_sha256 BLOB    NOT NULL CHECK (length(request_sha256) = 32),
    status         INTEGER NOT NULL,
    location       TEXT,
    etag           TEXT,
    body           BLOB    NOT NULL,
    fit            INTEGER REFERENCES fits (seq),
    body_end       BLOB    CHECK ((body_end IS NULL) = (fit IS NULL)),
    created_at     TEXT    NOT NULL CHECK (length(created_at) = 27),
    UNIQUE (tenant, key, scope)
) STRICT;

INSERT INTO kept_answers (seq, tenant, key, scope, request_sha256, status, location, etag, body, created_at)
SELECT seq, 'default', key, scope, request_sha256, status, location, etag, body, created_at FROM idempotency_keys ORDER BY seq;

-- A dropped table takes its index along.
DROP TABLE idempotency_keys;

ALTER TABLE kept_answers RENAME TO idempotency_keys;

CREATE INDEX idempotency_keys_by_age ON idempotency_keys (created_at);
