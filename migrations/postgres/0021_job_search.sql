-- Indexes of the list of jobs: of the text that is searched, of each filter in the order of the last change, and of the order by name.

-- The texts have a table of their own, so that a change of a job that leaves its text as it is leaves this index alone.
-- folded: that of the job; of one that a process of the version before has written, what the database knows.
CREATE TABLE job_texts (
    job uuid PRIMARY KEY REFERENCES jobs ON DELETE CASCADE,
    tenant text NOT NULL,
    folded text NOT NULL
);

-- The parts of a text of one, two and three letters, and its tenant behind four line ends, which is no part of a text. (pg_trgm
-- would need an extension, and knows letters and digits only.) The texts of a job have at most 21,000 letters.
CREATE FUNCTION text_parts(tenant text, searched text) RETURNS text[] LANGUAGE sql IMMUTABLE PARALLEL SAFE AS $$
    SELECT array_agg(part) || (E'\n\n\n\n' || tenant)
    FROM (
        SELECT DISTINCT unnest(ARRAY[letter, letter || next, letter || next || after]) COLLATE "C" AS part
        FROM (
            SELECT letter, lead(letter) OVER letters AS next, lead(letter, 2) OVER letters AS after
            FROM unnest(string_to_array(left(searched, 100000), NULL)) WITH ORDINALITY AS each (letter, place)
            WINDOW letters AS (ORDER BY place)
        ) AS three
    ) AS parts
    WHERE part IS NOT NULL
$$;

CREATE FUNCTION note_text() RETURNS trigger LANGUAGE plpgsql SECURITY DEFINER SET search_path FROM CURRENT AS $$
BEGIN
    INSERT INTO job_texts (job, tenant, folded) VALUES (
        NEW.id, NEW.tenant,
        coalesce(
            NEW.folded,
            lower(concat(NEW.name, E'\n', NEW.part_number, E'\n', NEW.serial_number, E'\n', NEW.machine, E'\n'))
                || coalesce((SELECT string_agg(lower(concat(key, ':', value, E'\n')), '') FROM json_each_text(NEW.tags::json)), '')
        )
    )
    ON CONFLICT (job) DO UPDATE SET folded = excluded.folded;
    RETURN NULL;
END
$$;
CREATE TRIGGER text_of_new_jobs AFTER INSERT ON jobs FOR EACH ROW EXECUTE FUNCTION note_text();
CREATE TRIGGER text_of_jobs AFTER UPDATE OF folded, name, part_number, serial_number, machine, tags ON jobs FOR EACH ROW
WHEN (NEW.folded IS NULL OR NEW.folded IS DISTINCT FROM OLD.folded) EXECUTE FUNCTION note_text();

INSERT INTO job_texts (job, tenant, folded) SELECT id, tenant, coalesce(
    folded,
    lower(concat(name, E'\n', part_number, E'\n', serial_number, E'\n', machine, E'\n'))
        || coalesce((SELECT string_agg(lower(concat(key, ':', value, E'\n')), '') FROM json_each_text(tags::json)), '')
) FROM jobs;

-- What is new waits in a list that each search reads, hence a short one.
CREATE INDEX job_texts_by_part ON job_texts USING gin (text_parts(tenant, folded)) WITH (gin_pending_list_limit = 256);

-- At most so many jobs whose text has all of these parts. What the planner does not know is how many there are: it always goes by the
-- index.
CREATE FUNCTION jobs_with_parts(parts text[], most bigint) RETURNS SETOF uuid LANGUAGE sql STABLE SET enable_seqscan = off
SET search_path FROM CURRENT AS $$
    SELECT job FROM job_texts WHERE text_parts(tenant, folded) @> parts LIMIT most
$$;

-- What jobs are sorted by where it is by name: the first line of what is searched, as much of it as an index takes. The trigger comes
-- after folded_of_jobs.
ALTER TABLE jobs ADD COLUMN sort_name text COLLATE "C";
UPDATE jobs SET sort_name = left(split_part(coalesce(folded, lower(name)), E'\n', 1), 400);

CREATE FUNCTION note_sort_name() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
    NEW.sort_name := left(split_part(coalesce(NEW.folded, lower(NEW.name)), E'\n', 1), 400);
    RETURN NEW;
END
$$;
CREATE TRIGGER sort_name_of_jobs BEFORE INSERT OR UPDATE OF folded, name ON jobs FOR EACH ROW EXECUTE FUNCTION note_sort_name();

CREATE INDEX jobs_by_name ON jobs (tenant, sort_name, id);
CREATE INDEX jobs_by_machine ON jobs (tenant, left(machine, 400), changed_at, id) WHERE machine IS NOT NULL;
CREATE INDEX jobs_by_part ON jobs (tenant, left(part_number, 400), changed_at, id) WHERE part_number IS NOT NULL;
CREATE INDEX jobs_by_class ON jobs (tenant, class, changed_at, id) WHERE class IS NOT NULL;
DROP INDEX jobs_by_status;
CREATE INDEX jobs_by_status ON jobs (tenant, status, changed_at, id);
