-- How far what is told of all jobs had come at which time: so it is known without looking at each row what was told when. gone: what was
-- told until then was forgotten since, or is about to be, and whoever asks for what came after a place before it has missed something.
CREATE TABLE told_until (
    at    TEXT    NOT NULL PRIMARY KEY CHECK (length(at) = 27),
    place INTEGER NOT NULL CHECK (place >= 0),
    gone  INTEGER NOT NULL DEFAULT 0 CHECK (gone IN (0, 1))
) STRICT, WITHOUT ROWID;
