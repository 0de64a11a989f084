-- Scores of segments may lie in Parquet files beside the database, too.
ALTER TABLE segment_score
    ADD COLUMN scores_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT);
