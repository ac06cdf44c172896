-- Indexes of the list of jobs: of the text that is searched, of each filter in the order of the last change, and of the order by name.

-- Three letters at a time of jobs.folded, with a line end behind it, so that each letter of a text begins three. Without content:
-- what is found is compared with jobs.folded. Deleted entries leave nothing in the file.
CREATE VIRTUAL TABLE jobs_text USING fts5(
    folded, content = '', columnsize = 0, detail = 'none', tokenize = 'trigram case_sensitive 1'
);
INSERT INTO jobs_text (jobs_text, rank) VALUES ('secure-delete', 1);
CREATE VIRTUAL TABLE jobs_text_terms USING fts5vocab(jobs_text, 'instance');

INSERT INTO jobs_text (rowid, folded) SELECT seq, folded || char(10) FROM jobs WHERE folded NOTNULL;

CREATE TRIGGER text_of_new_jobs AFTER INSERT ON jobs WHEN NEW.folded NOTNULL
BEGIN
    INSERT INTO jobs_text (rowid, folded) VALUES (NEW.seq, NEW.folded || char(10));
END;

CREATE TRIGGER text_of_jobs AFTER UPDATE OF folded ON jobs WHEN NEW.folded IS NOT OLD.folded
BEGIN
    INSERT INTO jobs_text (jobs_text, rowid, folded) SELECT 'delete', OLD.seq, OLD.folded || char(10) WHERE OLD.folded NOTNULL;
    INSERT INTO jobs_text (rowid, folded) SELECT NEW.seq, NEW.folded || char(10) WHERE NEW.folded NOTNULL;
END;

CREATE TRIGGER text_of_deleted_jobs AFTER DELETE ON jobs WHEN OLD.folded NOTNULL
BEGIN
    INSERT INTO jobs_text (jobs_text, rowid, folded) VALUES ('delete', OLD.seq, OLD.folded || char(10));
END;

-- What jobs are sorted by where it is by name: the first line of what is searched.
ALTER TABLE jobs ADD COLUMN sort_name TEXT GENERATED ALWAYS AS (
    substr(coalesce(folded, lower(name) || char(10)), 1, instr(coalesce(folded, lower(name) || char(10)), char(10)) - 1)
) VIRTUAL;

CREATE INDEX jobs_by_name ON jobs (tenant, sort_name, id);
CREATE INDEX jobs_by_machine ON jobs (tenant, machine, changed_at, id) WHERE machine NOTNULL;
CREATE INDEX jobs_by_part ON jobs (tenant, part_number, changed_at, id) WHERE part_number NOTNULL;
CREATE INDEX jobs_by_class ON jobs (tenant, class, changed_at, id) WHERE class NOTNULL;
DROP INDEX jobs_by_status;
CREATE INDEX jobs_by_status ON jobs (tenant, status, changed_at, id);
