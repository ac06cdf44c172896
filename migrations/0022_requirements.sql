-- What the flanks of a job must be like, as a JSON document.
ALTER TABLE jobs ADD COLUMN requirements TEXT;

-- Slopes, crownings and twist of a fit whose nodes are told to be on a flank, by the job's gear and requirements of that time: the JSON
-- document that was answered. Fits from before have none.
ALTER TABLE fits ADD COLUMN flank_figures TEXT;

-- A purge takes these away, and who made the fit.
DROP TRIGGER fits_no_update;
CREATE TRIGGER fits_no_update BEFORE UPDATE ON fits
WHEN NEW.reason NOTNULL OR NEW.actor NOTNULL OR NEW.flank_figures NOTNULL OR NEW.spec <> '' OR NEW.result <> '' OR NEW.frame NOTNULL
     OR NEW.coefficients NOTNULL OR NEW.prior NOTNULL
     OR NOT EXISTS (SELECT 1 FROM iterations i JOIN purges p ON p.job = i.job WHERE i.seq = OLD.iteration)
     OR (NEW.seq, NEW.id, NEW.iteration, NEW.created_at, NEW.lambda_star, NEW.criterion, NEW.scheme, NEW.count, NEW.condition,
         NEW.regularized_condition, NEW.bias_norm, NEW.bias_sharp_bound, NEW.rms, NEW.max_abs)
     IS NOT (OLD.seq, OLD.id, OLD.iteration, OLD.created_at, OLD.lambda_star, OLD.criterion, OLD.scheme, OLD.count, OLD.condition,
         OLD.regularized_condition, OLD.bias_norm, OLD.bias_sharp_bound, OLD.rms, OLD.max_abs)
BEGIN
    SELECT RAISE (ABORT, 'fits is append-only');
END;
