-- Segments are saved capture by capture; how they move follows from motion and is in the cache.
ALTER TABLE segment_score RENAME TO former_score;
CREATE TABLE segment_score (
    capture_id BIGINT NOT NULL,
    scores FLOAT[] NOT NULL,
    run_id BIGINT NOT NULL
);
INSERT INTO segment_score
    SELECT capture_id, flatten(list(scores ORDER BY ordinal)), max(s.run_id)
    FROM segment s JOIN former_score USING (ordinal) GROUP BY capture_id ORDER BY capture_id;
DROP TABLE former_score;
DROP TABLE segment_movement;
ALTER TABLE segment DROP COLUMN ordinal;
INSERT INTO meta VALUES ('segment_revision', replace(uuid()::VARCHAR, '-', ''));
