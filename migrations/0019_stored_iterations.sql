-- Three names and more after IN are looked up in a table that is made anew each time a trigger writes a row: an event took longer than all the
-- other rows of an iteration. The same said with OR is compared. Rows and triggers stay as they are, so the text alone is changed, as SQLite's
-- documentation of ALTER TABLE describes for constraints; where it is another text by now, it stays. What follows here makes every connection
-- read the schema anew.
PRAGMA writable_schema = ON;
UPDATE sqlite_schema SET sql = replace(replace(replace(sql,
    'CHECK (kind IN (''iteration'', ''fit'', ''decision'', ''stream'', ''operation''))',
    'CHECK (kind = ''iteration'' OR kind = ''fit'' OR kind = ''decision'' OR kind = ''stream'' OR kind = ''operation'')'),
    'CHECK (state IN (''open'', ''block'', ''finished'', ''deleted''))',
    'CHECK (state = ''open'' OR state = ''block'' OR state = ''finished'' OR state = ''deleted'')'),
    'CHECK (operation_state IN (''queued'', ''succeeded'', ''failed'', ''cancelled''))',
    'CHECK (operation_state = ''queued'' OR operation_state = ''succeeded'' OR operation_state = ''failed'' OR operation_state = ''cancelled'')')
WHERE type = 'table' AND name = 'events';
PRAGMA writable_schema = RESET;

-- A long result is kept as a frame of zstd: frame is that, result then is empty, and coefficients and prior are what the trace tells of it, as
-- it stands there. Older results, and short ones, are texts as before.
ALTER TABLE fits ADD COLUMN frame BLOB CHECK (frame IS NULL OR result = '');
ALTER TABLE fits ADD COLUMN coefficients TEXT CHECK (coefficients IS NULL OR frame IS NOT NULL);
ALTER TABLE fits ADD COLUMN prior TEXT CHECK (prior IS NULL OR frame IS NOT NULL);

DROP TRIGGER fits_no_update;
CREATE TRIGGER fits_no_update BEFORE UPDATE ON fits
WHEN NEW.reason NOTNULL OR NEW.spec <> '' OR NEW.result <> '' OR NEW.frame NOTNULL OR NEW.coefficients NOTNULL OR NEW.prior NOTNULL
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
     OR (NEW.seq, NEW.id, NEW.iteration, NEW.created_at, NEW.lambda_star, NEW.criterion, NEW.scheme, NEW.count, NEW.condition,
         NEW.regularized_condition, NEW.bias_norm, NEW.bias_sharp_bound, NEW.rms, NEW.max_abs)
     IS NOT (OLD.seq, OLD.id, OLD.iteration, OLD.created_at, OLD.lambda_star, OLD.criterion, OLD.scheme, OLD.count, OLD.condition,
         OLD.regularized_condition, OLD.bias_norm, OLD.bias_sharp_bound, OLD.rms, OLD.max_abs)
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;

-- Who stores many iterations notes them in their jobs once, before they are there; only what was not noted so is noted here. The first fit and
-- the first choice are made with their iteration.
DROP TRIGGER change_of_iterations;
DROP TRIGGER change_of_fits;
DROP TRIGGER change_of_choices;

CREATE TRIGGER change_of_iterations AFTER INSERT ON iterations
WHEN EXISTS (SELECT 1 FROM jobs WHERE seq = NEW.job AND (iteration_count < NEW.number OR changed_at < NEW.created_at))
BEGIN
    UPDATE jobs SET
        iteration_count = max(iteration_count, NEW.number), status = 'open', changed_at = max(changed_at, NEW.created_at)
    WHERE seq = NEW.job;
END;

CREATE TRIGGER change_of_fits AFTER INSERT ON fits
WHEN EXISTS (SELECT 1 FROM fits WHERE iteration = NEW.iteration AND seq <> NEW.seq)
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration) AND changed_at < NEW.created_at;
END;

CREATE TRIGGER change_of_choices AFTER INSERT ON fit_choices WHEN NEW.position > 1
BEGIN
    UPDATE jobs SET changed_at = NEW.created_at
    WHERE seq = (SELECT job FROM iterations WHERE seq = NEW.iteration) AND changed_at < NEW.created_at;
END;
