-- Records are listed in the order in which they were stored, which is not that of their ids where requests meet. (The rows of an index
-- with equal columns are in the order of seq.)
DROP INDEX records_of_iteration;

CREATE INDEX records_of_iteration ON records (iteration);
