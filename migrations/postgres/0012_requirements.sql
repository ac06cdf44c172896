-- What the flanks of a job must be like, as a JSON document.
ALTER TABLE jobs ADD COLUMN requirements text;

-- Slopes, crownings and twist of a fit whose nodes are told to be on a flank, by the job's gear and requirements of that time: the JSON
-- document that was answered. Fits from before have none.
ALTER TABLE fits ADD COLUMN flank_figures text;
