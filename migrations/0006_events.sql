-- What happened to a job, numbered 1, 2, 3 … within it: the source of its event stream. Rows are written by triggers, hence in the
-- transaction of the thing itself, whoever writes it. They name what happened; the rest is read from the thing.
-- position: of a choice or a decision. stream, state, sequence, node_count: of a stream, which may be deleted later.
CREATE TABLE events (
    job        INTEGER NOT NULL REFERENCES jobs (seq),
    number     INTEGER NOT NULL CHECK (number >= 1),
    kind       TEXT    NOT NULL CHECK (kind IN ('iteration', 'fit', 'decision', 'stream')),
    iteration  INTEGER REFERENCES iterations (seq),
    fit        INTEGER REFERENCES fits (seq),
    position   INTEGER,
    stream     BLOB    CHECK (length(stream) = 16),
    state      TEXT    CHECK (state IN ('open', 'block', 'finished', 'deleted')),
    sequence   INTEGER,
    node_count INTEGER,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    PRIMARY KEY (job, number)
) STRICT, WITHOUT ROWID;

-- What happened before there was this table, in the order of its times.
INSERT INTO events (job, number, kind, iteration, fit, position, created_at)
SELECT job, row_number() OVER (PARTITION BY job ORDER BY created_at, iteration, rank, place),
       kind, iteration, fit, position, created_at
FROM (
    SELECT job, 'iteration' AS kind, seq AS iteration, NULL AS fit, NULL AS position, created_at, 0 AS rank, 0 AS place
    FROM iterations
    UNION ALL
    SELECT i.job, 'fit', i.seq, f.seq, NULL, f.created_at, 1, f.seq
    FROM fits f JOIN iterations i ON i.seq = f.iteration
    WHERE f.seq > (SELECT min(seq) FROM fits WHERE iteration = i.seq)
    UNION ALL
    SELECT i.job, 'fit', i.seq, c.fit, c.position, c.created_at, 2, c.position
    FROM fit_choices c JOIN iterations i ON i.seq = c.iteration WHERE c.position > 1
    UNION ALL
    SELECT i.job, 'decision', i.seq, NULL, d.position, d.created_at, 3, d.position
    FROM decisions d JOIN iterations i ON i.seq = d.iteration
);

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
