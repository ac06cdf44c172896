-- Curves and surfaces kept with an iteration: the request that described each, and the answer as it was given.
CREATE TABLE shapes (
    seq        INTEGER PRIMARY KEY,
    id         BLOB    NOT NULL UNIQUE CHECK (length(id) = 16),
    iteration  INTEGER NOT NULL REFERENCES iterations (seq),
    kind       TEXT    NOT NULL CHECK (kind IN ('curve', 'surface')),
    method     TEXT    NOT NULL,
    created_at TEXT    NOT NULL CHECK (length(created_at) = 27),
    request    TEXT    NOT NULL,
    result     TEXT    NOT NULL
) STRICT;

CREATE INDEX shapes_of_iteration ON shapes (iteration, id);

CREATE TRIGGER shapes_no_update BEFORE UPDATE ON shapes
BEGIN
    SELECT RAISE (ABORT, 'shapes is append-only');
END;

CREATE TRIGGER shapes_no_delete BEFORE DELETE ON shapes
BEGIN
    SELECT RAISE (ABORT, 'shapes is append-only');
END;
