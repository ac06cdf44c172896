-- Requests that are answered later. headers and result_headers are JSON documents; body and result are frames of zstd. key: the client's
-- idempotency key, or one of the operation's own; key_scope: method and path. Of an operation that runs, lease names who does it and until
-- when; of one that waits, lease_until says before when nobody takes it. bytes: what it takes here. What an operation has stored is answered
-- from idempotency_keys, so result is NULL then; status is not.
CREATE TABLE operations (
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
    headers        TEXT    NOT NULL,
    body           BLOB    NOT NULL,
    state          TEXT    NOT NULL CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempts       INTEGER NOT NULL CHECK (attempts >= 0),
    lease          BLOB    CHECK (length(lease) = 16),
    lease_until    TEXT    CHECK (length(lease_until) = 27),
    progress       REAL    NOT NULL,
    told_at        TEXT    CHECK (length(told_at) = 27),
    status         INTEGER,
    result_headers TEXT,
    result         BLOB,
    bytes          INTEGER NOT NULL,
    created_at     TEXT    NOT NULL CHECK (length(created_at) = 27),
    begun_at       TEXT    CHECK (length(begun_at) = 27),
    ended_at       TEXT    CHECK (length(ended_at) = 27),
    UNIQUE (tenant, key, key_scope)
) STRICT, WITHOUT ROWID;

CREATE INDEX operations_open ON operations (created_at, id) WHERE state IN ('queued', 'running');

CREATE INDEX operations_by_end ON operations (ended_at) WHERE ended_at IS NOT NULL;

-- Events of a job tell of its operations, too: the table is made anew, since a column's check cannot be changed. So are the triggers that
-- write into it.
DROP TRIGGER events_of_iterations;
DROP TRIGGER events_of_fits;
DROP TRIGGER events_of_choices;
DROP TRIGGER events_of_decisions;
DROP TRIGGER events_of_new_streams;
DROP TRIGGER events_of_blocks;
DROP TRIGGER events_of_finished_streams;
DROP TRIGGER events_of_deleted_streams;

CREATE TABLE events_with_operations (
    job             INTEGER NOT NULL REFERENCES jobs (seq),
    number          INTEGER NOT NULL CHECK (number >= 1),
    kind            TEXT    NOT NULL CHECK (kind IN ('iteration', 'fit', 'decision', 'stream', 'operation')),
    iteration       INTEGER REFERENCES iterations (seq),
    fit             INTEGER REFERENCES fits (seq),
    position        INTEGER,
    stream          BLOB    CHECK (length(stream) = 16),
    state           TEXT    CHECK (state IN ('open', 'block', 'finished', 'deleted')),
    sequence        INTEGER,
    node_count      INTEGER,
    operation       BLOB    CHECK (length(operation) = 16),
    operation_state TEXT    CHECK (operation_state IN ('queued', 'succeeded', 'failed', 'cancelled')),
    created_at      TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (job, number)
) STRICT, WITHOUT ROWID;

INSERT INTO events_with_operations (job, number, kind, iteration, fit, position, stream, state, sequence, node_count, created_at)
SELECT job, number, kind, iteration, fit, position, stream, state, sequence, node_count, created_at FROM events;

DROP TABLE events;

ALTER TABLE events_with_operations RENAME TO events;

CREATE TRIGGER events_of_iterations AFTER INSERT ON iterations
BEGIN
    INSERT INTO events (job, number, kind, iteration, created_at)
    VALUES (NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'iteration', NEW.seq, NEW.created_at);
END;

-- The first fit belongs to its iteration's event.
CREATE TRIGGER events_of_fits AFTER INSERT ON fits
WHEN EXISTS (SELECT 1 FROM fits WHERE iteration = NEW.iteration AND seq <> NEW.seq)
BEGIN
    INSERT INTO events (job, number, kind, iteration, fit, created_at)
    SELECT i.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = i.job), 'fit', i.seq, NEW.seq, NEW.created_at
    FROM iterations i WHERE i.seq = NEW.iteration;
END;

CREATE TRIGGER events_of_choices AFTER INSERT ON fit_choices WHEN NEW.position > 1
BEGIN
    INSERT INTO events (job, number, kind, iteration, fit, position, created_at)
    SELECT i.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = i.job), 'fit', i.seq, NEW.fit, NEW.position,
           NEW.created_at
    FROM iterations i WHERE i.seq = NEW.iteration;
END;

CREATE TRIGGER events_of_decisions AFTER INSERT ON decisions
BEGIN
    INSERT INTO events (job, number, kind, iteration, position, created_at)
    SELECT i.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = i.job), 'decision', i.seq, NEW.position,
           NEW.created_at
    FROM iterations i WHERE i.seq = NEW.iteration;
END;

CREATE TRIGGER events_of_new_streams AFTER INSERT ON streams
BEGIN
    INSERT INTO events (job, number, kind, stream, state, sequence, node_count, created_at)
    VALUES (NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'stream', NEW.id, 'open',
            NEW.sequence, NEW.node_count, NEW.created_at);
END;

CREATE TRIGGER events_of_blocks AFTER UPDATE OF sequence ON streams WHEN NEW.sequence > OLD.sequence
BEGIN
    INSERT INTO events (job, number, kind, stream, state, sequence, node_count, created_at)
    VALUES (NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'stream', NEW.id, 'block',
            NEW.sequence, NEW.node_count, NEW.updated_at);
END;

CREATE TRIGGER events_of_finished_streams AFTER UPDATE OF iteration ON streams
WHEN OLD.iteration IS NULL AND NEW.iteration IS NOT NULL
BEGIN
    INSERT INTO events (job, number, kind, iteration, stream, state, sequence, node_count, created_at)
    VALUES (NEW.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = NEW.job), 'stream', NEW.iteration, NEW.id,
            'finished', NEW.sequence, NEW.node_count, NEW.updated_at);
END;

-- Whoever deletes a stream first sets its updated_at.
CREATE TRIGGER events_of_deleted_streams AFTER DELETE ON streams
BEGIN
    INSERT INTO events (job, number, kind, iteration, stream, state, sequence, node_count, created_at)
    VALUES (OLD.job, (SELECT coalesce(max(number), 0) + 1 FROM events WHERE job = OLD.job), 'stream', OLD.iteration, OLD.id,
            'deleted', OLD.sequence, OLD.node_count, OLD.updated_at);
END;

CREATE TRIGGER events_no_update BEFORE UPDATE ON events
BEGIN
    SELECT RAISE (ABORT, 'events is append-only');
END;

-- Only a job that has nothing else takes its events along.
CREATE TRIGGER events_no_delete BEFORE DELETE ON events
WHEN EXISTS (SELECT 1 FROM iterations WHERE job = OLD.job) OR EXISTS (SELECT 1 FROM streams WHERE job = OLD.job)
BEGIN
    SELECT RAISE (ABORT, 'events is append-only');
END;

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
