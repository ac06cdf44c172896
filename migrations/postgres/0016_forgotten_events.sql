-- How far what is told of all jobs had come at which time: all transactions up to this one had ended. So it is known without looking at each
-- row what was told when. gone: what was told until then was forgotten since, or is about to be, and whoever asks for what came after a
-- place before it has missed something.
CREATE TABLE told_until (
    at         timestamptz PRIMARY KEY,
    changed_by bigint      NOT NULL,
    gone       boolean     NOT NULL DEFAULT false
);
