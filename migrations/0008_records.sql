-- Records: whatever is kept with an iteration beside its fits, the request that described each and the answer as it was given.
-- Curves and surfaces, until now a table of their own, are two kinds of them.
CREATE TABLE records (
    seq        INTEGER PRIMARY KEY,
    id         BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    iteration  INTEGER NOT NULL REFERENCES iterations (seq),
    kind       TEXT    NOT NULL CHECK (kind IN ('curve', 'surface', 'deviations', 'evaluation', 'correction')),
    method     TEXT    NOT NULL,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    request    TEXT    NOT NULL,
    result     TEXT    NOT NULL
) STRICT;

INSERT INTO records (seq, id, iteration, kind, method, created_at, request, result)
SELECT seq, id, iteration, kind, method, created_at, request, result FROM shapes ORDER BY seq;

-- A dropped table takes its triggers and indices along.
DROP TABLE shapes;

CREATE INDEX records_of_iteration ON records (iteration, id);

CREATE TRIGGER records_no_update BEFORE UPDATE ON records
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;

CREATE TRIGGER records_no_delete BEFORE DELETE ON records
BEGIN
    SELECT RAISE (ABORT, 'records is append-only');
END;
