-- What the list of jobs is filtered and sorted by. Triggers keep it, hence in the transaction of whatever changes it; but for folded, the
-- text that is searched, which the writer gives, since SQLite knows the lower case of ASCII only. Rows without it are given one when the
-- database is opened.
-- changed_at: when anything of the job was stored last. status: of the decision on the last iteration.
ALTER TABLE jobs ADD COLUMN changed_at TEXT NOT NULL DEFAULT '1970-01-01T00:00:00.000000Z' CHECK (length(changed_at) = 27);
ALTER TABLE jobs ADD COLUMN iteration_count INTEGER NOT NULL DEFAULT 0 CHECK (iteration_count >= 0);
ALTER TABLE jobs ADD COLUMN status TEXT NOT NULL DEFAULT 'new'
    CHECK (status IN ('new', 'open', 'remachine', 'accepted', 'rejected'));
ALTER TABLE jobs ADD COLUMN folded TEXT;

UPDATE jobs SET iteration_count = coalesce((SELECT max(i.number) FROM iterations i WHERE i.job = jobs.seq), 0);

UPDATE jobs SET
    status = CASE (SELECT d.decision FROM iterations i JOIN decisions d ON d.iteration = i.seq
                   WHERE i.job = jobs.seq AND i.number = jobs.iteration_count ORDER BY d.position DESC LIMIT 1)
        WHEN 'accept' THEN 'accepted' WHEN 'reject' THEN 'rejected' WHEN 'remachine' THEN 'remachine'
        ELSE iif(iteration_count > 0, 'open', 'new') END,
    changed_at = max(
        updated_at,
        coalesce((SELECT max(i.created_at) FROM iterations i WHERE i.job = jobs.seq), ''),
        coalesce((SELECT max(f.created_at) FROM iterations i JOIN fits f ON f.iteration = i.seq WHERE i.job = jobs.seq), ''),
        coalesce((SELECT max(c.created_at) FROM iterations i JOIN fit_choices c ON c.iteration = i.seq WHERE i.job = jobs.seq), ''),
        coalesce((SELECT max(d.created_at) FROM iterations i JOIN decisions d ON d.iteration = i.seq WHERE i.job = jobs.seq), ''),
        coalesce((SELECT max(r.created_at) FROM iterations i JOIN records r ON r.iteration = i.seq WHERE i.job = jobs.seq), '')
    );

CREATE INDEX jobs_by_change ON jobs (tenant, changed_at, id);
CREATE INDEX jobs_by_status ON jobs (tenant, status, machine);
CREATE INDEX jobs_not_folded ON jobs (id) WHERE folded IS NULL;

CREATE TRIGGER change_of_new_jobs AFTER INSERT ON jobs
BEGIN
    UPDATE jobs SET changed_at = NEW.updated_at WHERE seq = NEW.seq;
END;

CREATE TRIGGER change_of_jobs AFTER UPDATE OF updated_at ON jobs WHEN NEW.updated_at > NEW.changed_at
BEGIN
    UPDATE jobs SET changed_at = NEW.updated_at WHERE seq = NEW.seq;
END;

CREATE TRIGGER change_of_iterations AFTER INSERT ON iterations
BEGIN
    UPDATE jobs SET iteration_count = NEW.number, status = 'open', changed_at = max(changed_at, NEW.created_at) WHERE seq = NEW.job;
END;

CREATE TRIGGER change_of_fits AFTER INSERT ON fits
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration) AND changed_at < NEW.created_at;
END;

CREATE TRIGGER change_of_choices AFTER INSERT ON fit_choices
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration) AND changed_at < NEW.created_at;
END;

CREATE TRIGGER change_of_records AFTER INSERT ON records
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration) AND changed_at < NEW.created_at;
END;

-- A decision on an earlier iteration is no decision on the gear as it is.
CREATE TRIGGER change_of_decisions AFTER INSERT ON decisions
BEGIN
    UPDATE jobs SET
        changed_at = max(changed_at, NEW.created_at),
        status = iif(
            iteration_count = (SELECT number FROM iterations WHERE seq = NEW.iteration),
            CASE NEW.decision WHEN 'accept' THEN 'accepted' WHEN 'reject' THEN 'rejected' ELSE 'remachine' END,
            status
        )
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration);
END;
