-- What is short stands before bodies and results: a row is read up to the last column that is asked for, and what stands behind a result
-- of many megabytes is reached through all of its pages. Who is next is found in an index alone, and so is what a tenant holds.
CREATE TABLE operations_short_first (
    id             BLOB    PRIMARY KEY CHECK (length(id) = 16),
    tenant         TEXT    NOT NULL CHECK (length(tenant) BETWEEN 1 AND 63),
    actor          TEXT    NOT NULL,
    request_id     TEXT,
    peer           TEXT,
    scope          TEXT    NOT NULL,
    scopes         TEXT    NOT NULL,
    request        TEXT    NOT NULL,
    job            BLOB    CHECK (length(job) = 16),
    key            TEXT    NOT NULL,
    key_scope      TEXT    NOT NULL,
    request_sha256 BLOB    NOT NULL CHECK (length(request_sha256) = 32),
    state          TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempts       INTEGER NOT NULL CHECK (attempts >= 0),
    lease          BLOB    CHECK (length(lease) = 16),
    lease_until    TEXT    CHECK (length(lease_until) = 27),
    progress       REAL    NOT NULL,
    told_at        TEXT    CHECK (length(told_at) = 27),
    status         INTEGER,
    bytes          INTEGER NOT NULL,
    created_at     TEXT    NOT NULL CHECK (length(created_at) = 27),
    begun_at       TEXT    CHECK (length(begun_at) = 27),
    ended_at       TEXT    CHECK (length(ended_at) = 27),
    headers        TEXT    NOT NULL,
    result_headers TEXT,
    body           BLOB    NOT NULL,
    result         BLOB,
    UNIQUE (tenant, key, key_scope)
) STRICT, WITHOUT ROWID;

INSERT INTO operations_short_first (id, tenant, actor, request_id, peer, scope, scopes, request, job, key, key_scope, request_sha256, state,
    attempts, lease, lease_until, progress, told_at, status, bytes, created_at, begun_at, ended_at, headers, result_headers, body, result)
SELECT id, tenant, actor, request_id, peer, scope, scopes, request, job, key, key_scope, request_sha256, state, attempts, lease, lease_until,
    progress, told_at, status, bytes, created_at, begun_at, ended_at, headers, result_headers, body, result
FROM operations;

DROP TABLE operations;

ALTER TABLE operations_short_first RENAME TO operations;

CREATE INDEX operations_open ON operations (state, tenant, created_at, lease_until) WHERE state IN ('queued', 'running');

CREATE INDEX operations_held ON operations (tenant, state, bytes);

CREATE INDEX operations_by_end ON operations (ended_at) WHERE ended_at IS NOT NULL;

-- A job may be deleted before its operation has ended.
CREATE TRIGGER events_of_new_operations AFTER INSERT ON operations WHEN NEW.job IS NOT NULL
BEGIN
    INSERT INTO events (job, number, kind, operation, operation_state, created_at)
    SELECT j.seq, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = j.seq), 'operation', NEW.id, NEW.state, NEW.created_at
    FROM jobs j WHERE j.id = NEW.job AND j.tenant = NEW.tenant;
END;

CREATE TRIGGER events_of_ended_operations AFTER UPDATE OF state ON operations
WHEN NEW.job IS NOT NULL AND OLD.ended_at IS NULL AND NEW.ended_at IS NOT NULL
BEGIN
    INSERT INTO events (job, number, kind, operation, operation_state, created_at)
    SELECT j.seq, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = j.seq), 'operation', NEW.id, NEW.state, NEW.ended_at
    FROM jobs j WHERE j.id = NEW.job AND j.tenant = NEW.tenant;
END;
