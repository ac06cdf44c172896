-- What the list of jobs is filtered and sorted by. Triggers keep it, hence in the transaction of whatever changes it; but for folded, the
-- text that is searched, which the writer gives, since the lower case of letters is another one in each locale. Rows without it (older
-- ones, and those that a process of the version before writes) are given one by `migrate`.
-- changed_at: when anything of the job was stored last. status: of the decision on the last iteration.
ALTER TABLE jobs ADD COLUMN changed_at timestamptz NOT NULL DEFAULT 'epoch';
ALTER TABLE jobs ADD COLUMN iteration_count bigint NOT NULL DEFAULT 0 CHECK (iteration_count >= 0);
ALTER TABLE jobs ADD COLUMN status text NOT NULL DEFAULT 'new'
    CHECK (status IN ('new', 'open', 'remachine', 'accepted', 'rejected'));
ALTER TABLE jobs ADD COLUMN folded text;

CREATE FUNCTION status_of(decision text) RETURNS text LANGUAGE sql IMMUTABLE AS $$
    SELECT CASE decision WHEN 'accept' THEN 'accepted' WHEN 'reject' THEN 'rejected' ELSE decision END
$$;

UPDATE jobs SET iteration_count = coalesce((SELECT max(number) FROM iterations WHERE job = jobs.id), 0);

UPDATE jobs SET
    status = coalesce(
        (SELECT status_of(decision) FROM decisions WHERE job = jobs.id AND number = jobs.iteration_count ORDER BY position DESC LIMIT 1),
        CASE WHEN iteration_count > 0 THEN 'open' ELSE 'new' END
    ),
    changed_at = greatest(
        updated_at,
        (SELECT max(created_at) FROM iterations WHERE job = jobs.id),
        (SELECT max(created_at) FROM fits WHERE job = jobs.id),
        (SELECT max(created_at) FROM fit_choices WHERE job = jobs.id),
        (SELECT max(created_at) FROM decisions WHERE job = jobs.id),
        (SELECT max(created_at) FROM records WHERE job = jobs.id)
    );

CREATE INDEX jobs_by_change ON jobs (tenant, changed_at, id);
CREATE INDEX jobs_by_status ON jobs (tenant, status);
CREATE INDEX jobs_not_folded ON jobs (id) WHERE folded IS NULL;

CREATE FUNCTION note_change_of_job() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    NEW.changed_at := greatest(NEW.changed_at, NEW.updated_at);
    RETURN NEW;
END
$$;
CREATE TRIGGER change_of_jobs BEFORE INSERT OR UPDATE OF updated_at ON jobs FOR EACH ROW EXECUTE FUNCTION note_change_of_job();

-- A process of the version before changes what is searched and leaves folded as it was.
CREATE FUNCTION forget_folded() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    NEW.folded := NULL;
    RETURN NEW;
END
$$;
CREATE TRIGGER folded_of_jobs BEFORE UPDATE OF name, part_number, serial_number, machine, tags ON jobs FOR EACH ROW
WHEN (NEW.folded = OLD.folded
      AND (NEW.name, NEW.part_number, NEW.serial_number, NEW.machine, NEW.tags)
          IS DISTINCT FROM (OLD.name, OLD.part_number, OLD.serial_number, OLD.machine, OLD.tags))
EXECUTE FUNCTION forget_folded();

CREATE FUNCTION note_iteration() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET iteration_count = NEW.number, status = 'open', changed_at = greatest(changed_at, NEW.created_at) WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER change_of_iterations AFTER INSERT ON iterations FOR EACH ROW EXECUTE FUNCTION note_iteration();

CREATE FUNCTION note_change() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at WHERE id = NEW.job AND changed_at < NEW.created_at;
    RETURN NULL;
END
$$;
-- The first fit and the first choice are made with their iteration.
CREATE TRIGGER change_of_fits AFTER INSERT ON fits FOR EACH ROW WHEN (NEW.position > 1) EXECUTE FUNCTION note_change();
CREATE TRIGGER change_of_choices AFTER INSERT ON fit_choices FOR EACH ROW WHEN (NEW.position > 1) EXECUTE FUNCTION note_change();
CREATE TRIGGER change_of_records AFTER INSERT ON records FOR EACH ROW EXECUTE FUNCTION note_change();

-- A decision on an earlier iteration is no decision on the gear as it is.
CREATE FUNCTION note_decision() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    UPDATE jobs SET
        changed_at = greatest(changed_at, NEW.created_at),
        status = CASE WHEN iteration_count = NEW.number THEN status_of(NEW.decision) ELSE status END
    WHERE id = NEW.job;
    RETURN NULL;
END
$$;
CREATE TRIGGER change_of_decisions AFTER INSERT ON decisions FOR EACH ROW EXECUTE FUNCTION note_decision();
