-- Rules that constraints of the tables cannot express (see the head of schema.sql). `motiondb
-- check` asks each of them; a sound database has no answer to any.
--
-- A rule is a sentence and a query. Every row of the answer is a fault; its columns stand in place
-- of {} in the sentence. Rules that a quick check does not ask, since they read long tables, or all
-- of a grammar or scene, say so in a line "-- not quick". Where a rule holds of several tables,
-- lines "-- | a | b" give what stands in place of the names in their first line. A run that was
-- killed is no fault, unless derived rows refer to it. Blank lines part the rules.

-- ── Captures, and what was learned ──────────────────────────────────────────────────────────────

-- {}: expected one motion of as many frames as its row says, found others.
SELECT c.name FROM capture c
    LEFT JOIN (SELECT capture_id, count(*) AS n, max(n_frames) AS length FROM motion GROUP BY ALL) m
    USING (capture_id)
    WHERE coalesce(n, 0) <> 1 OR length <> motion_frames;

-- {}: expected events within its motion, found others.
SELECT DISTINCT c.name FROM capture c JOIN event e USING (capture_id)
    WHERE e.frame >= motion_frames;

-- {}: expected its file in the table source, found others.
SELECT name FROM capture ANTI JOIN source USING (sha256);

-- {}: expected segments that tile its motion, found others.
SELECT name FROM capture JOIN (
    SELECT capture_id, min(start_frame) AS low, max(end_frame) AS high,
        bool_and(end_frame > start_frame AND start_frame = previous) AS tiled
    FROM (SELECT *, lag(end_frame, 1, start_frame) OVER (
        PARTITION BY capture_id ORDER BY start_frame, end_frame) AS previous FROM segment)
    GROUP BY ALL) USING (capture_id)
    WHERE NOT tiled OR low <> 0 OR high <> motion_frames;

-- {}: expected the probabilities of its words to sum to 1, found others.
SELECT 'symbol ' || symbol_id FROM translation GROUP BY symbol_id
    HAVING abs(sum(coalesce(probability, 'nan'::DOUBLE)) - 1) > 0.0001
    OR isnan(sum(coalesce(probability, 'nan'::DOUBLE)));

-- {}: expected l + 1 alignment probabilities that sum to 1, found others.
SELECT 'alignment ' || l || ', ' || m || ', ' || j FROM alignment
    WHERE len(probabilities) <> l + 1 OR abs(list_sum(probabilities) - 1) > 0.0001;

-- {}: expected states numbered from 0, as many as its row says, found others.
SELECT 'symbol ' || symbol_id FROM symbol
    LEFT JOIN (SELECT symbol_id, count(*) AS n, max(state) AS high FROM symbol_state GROUP BY ALL)
    USING (symbol_id)
    WHERE coalesce(n, 0) <> n_states OR high <> n_states - 1;

-- {}: expected as many rows as the table learning says, found others.
SELECT 'table ' || name FROM (
    SELECT 'symbol' AS name, n_symbols = (SELECT count(*) FROM symbol) AS fits FROM learning
    UNION ALL SELECT 'symbol_distance', n_symbols ** 2 = (SELECT count(*) FROM symbol_distance)
        FROM learning
    UNION ALL SELECT 'cluster', n_clusters = (SELECT count(*) FROM cluster) FROM learning
    UNION ALL SELECT 'word', n_words = (SELECT count(*) FROM word) FROM learning
    UNION ALL SELECT 'learning', count(*) <= 1 FROM learning)
    WHERE NOT fits;

-- {}: expected a score of every segment for every symbol, found others.
-- not quick
SELECT c.name FROM (SELECT capture_id, count(*) AS n FROM segment GROUP BY ALL)
    LEFT JOIN segment_score USING (capture_id) LEFT JOIN capture c USING (capture_id)
    WHERE coalesce(scores_at.n_bytes // 4, len(scores))
        IS DISTINCT FROM n * (SELECT n_symbols FROM learning);

-- {}: expected one known source for every frame, found others.
-- not quick
SELECT name FROM capture
    JOIN (SELECT capture_id, count(*) AS n, max(frame) AS high, count(DISTINCT frame) AS d,
        max(source_ordinal) AS source FROM frame_source GROUP BY ALL) USING (capture_id)
    LEFT JOIN (SELECT capture_id, count(*) AS k FROM generated_source GROUP BY ALL)
    USING (capture_id)
    WHERE n <> motion_frames OR d <> n OR high <> n - 1 OR source >= coalesce(k, 0);

-- {}: expected the bytes of its file, which it was added with (motiondb add FILE fills them in),
-- found others.
-- not quick
SELECT name FROM capture JOIN run r USING (run_id) JOIN source USING (sha256)
    WHERE r.kind = 'add' AND r.parameters LIKE '%"originals": true%'
        AND octet_length(data) = 0 AND data_at IS NULL;

-- ── Numbers of other rows ───────────────────────────────────────────────────────────────────────

-- {table}: expected every {column} in {target}, found {} rows without, such as {}.
-- | table | column | target | key
-- | capture_tag | capture_id | capture | capture_id
-- | caption | capture_id | capture | capture_id
-- | event | capture_id | capture | capture_id
-- | motion | capture_id | capture | capture_id
-- | relation | capture_id | capture | capture_id
-- | relation | other_id | capture | capture_id
-- | generated_source | capture_id | capture | capture_id
-- | capture_quality | capture_id | capture | capture_id
-- | finding | capture_id | capture_quality | capture_id
-- | same_file | capture_id | capture | capture_id
-- | source | sha256 | capture | sha256
-- | motion | poses_at.file_id | parquet_file | file_id
-- | source | data_at.file_id | parquet_file | file_id
-- | source | skeleton_data_at.file_id | parquet_file | file_id
-- | segment | capture_id | capture | capture_id
-- | segment | symbol_id | symbol | symbol_id
-- | symbol | cluster_id | cluster | cluster_id
-- | symbol_state | symbol_id | symbol | symbol_id
-- | symbol_distance | symbol_id | symbol | symbol_id
-- | symbol_distance | other_id | symbol | symbol_id
-- | translation | symbol_id | symbol | symbol_id
-- | translation | word_id | word | word_id
-- | transition_count | symbol_id | symbol | symbol_id
-- | transition_count | next_id | symbol | symbol_id
SELECT count(*), min({column}) FROM {table}
    WHERE {column} NOT IN (SELECT {key} FROM {target}) AND {column}::VARCHAR <> '-1'
    HAVING count(*) > 0;

-- {table}: expected every {column} in {target}, found {} rows without, such as {}.
-- not quick
-- | table | column | target | key
-- | frame_source | capture_id | capture | capture_id
-- | segment_score | capture_id | segment | capture_id
-- | segment_score | scores_at.file_id | parquet_file | file_id
SELECT count(*), min({column}) FROM {table}
    WHERE {column} NOT IN (SELECT {key} FROM {target}) AND {column}::VARCHAR <> '-1'
    HAVING count(*) > 0;

-- ── Runs ────────────────────────────────────────────────────────────────────────────────────────

-- {table}: expected rows of the finished run of learn, found {} others.
-- not quick
-- | table
-- | learning
-- | symbol
-- | symbol_state
-- | symbol_distance
-- | space_stress
-- | cluster
-- | word
-- | translation
-- | alignment
-- | association_step
-- | transition_count
-- | parameter
SELECT count(*) FROM {table}
    WHERE run_id NOT IN (SELECT run_id FROM learning JOIN run USING (run_id) WHERE finished NOTNULL)
    HAVING count(*) > 0;

-- {table}: expected rows of a finished run, found {} others.
-- not quick
-- | table
-- | capture_quality
-- | finding
-- | segment
-- | segment_score
-- | grammar
-- | grammar_source
-- | terminal
-- | terminal_segment
-- | grammar_rule
-- | sentence
-- | grammar_bits
-- | scene
-- | scene_player
-- | scene_clip
-- | scene_rule
-- | scene_ball
-- | derivation
SELECT count(*) FROM {table}
    WHERE run_id NOT IN (SELECT run_id FROM run WHERE finished NOTNULL)
    HAVING count(*) > 0;

-- {table}: expected rows of a {parent} and of its run, found {} others.
-- not quick
-- | table | parent | key
-- | grammar_source | grammar | grammar_id
-- | terminal | grammar | grammar_id
-- | terminal_segment | grammar | grammar_id
-- | grammar_rule | grammar | grammar_id
-- | sentence | grammar | grammar_id
-- | grammar_bits | grammar | grammar_id
-- | scene_player | scene | scene_id
-- | scene_clip | scene | scene_id
-- | scene_rule | scene | scene_id
-- | scene_ball | scene | scene_id
SELECT count(*) FROM {table} LEFT JOIN {parent} p USING ({key})
    WHERE {table}.run_id IS DISTINCT FROM p.run_id
    HAVING count(*) > 0;

-- derivation: expected rows of a grammar and of a generated capture, found {} others.
-- not quick
SELECT count(*) FROM derivation
    WHERE capture_id NOT IN (SELECT capture_id FROM capture WHERE kind = 'generated')
        OR grammar_id NOT IN (SELECT grammar_id FROM grammar)
    HAVING count(*) > 0;

-- ── Housekeeping ────────────────────────────────────────────────────────────────────────────────

-- meta: expected a number for {}, found {}.
SELECT k, coalesce(value, 'nothing')
    FROM (VALUES ('schema'), ('next_capture_id'), ('revision')) keys (k) LEFT JOIN meta ON key = k
    WHERE NOT coalesce(regexp_full_match(value, '[0-9]+'), false);

-- meta: expected a mark for {}, found nothing.
SELECT k FROM (VALUES ('motion_revision'), ('segment_revision')) keys (k)
    ANTI JOIN meta ON key = k;

-- ── Grammars ────────────────────────────────────────────────────────────────────────────────────

-- grammar {}: expected segments that tile its takes, found others.
-- not quick
SELECT DISTINCT name FROM grammar JOIN grammar_source USING (grammar_id) LEFT JOIN (
    SELECT grammar_id, take, min(start_frame) AS low, max(end_frame) AS high,
        bool_and(end_frame > start_frame AND start_frame = previous) AS tiled
    FROM (SELECT *, lag(end_frame, 1, start_frame) OVER (
        PARTITION BY grammar_id, take ORDER BY ordinal) AS previous FROM terminal_segment)
    GROUP BY ALL) USING (grammar_id, take)
    WHERE NOT coalesce(tiled, false) OR low <> 0 OR high <> n_frames;

-- grammar {}: expected one medoid for every terminal, found others.
-- not quick
SELECT DISTINCT g.name FROM grammar g JOIN terminal t USING (grammar_id) LEFT JOIN (
    SELECT grammar_id, terminal, count(*) AS n FROM terminal_segment WHERE is_medoid GROUP BY ALL) s
    ON s.grammar_id = t.grammar_id AND s.terminal = t.ordinal
    WHERE coalesce(n, 0) <> 1;

-- grammar {}: expected the probabilities of a symbol's rules to sum to 1, found others.
-- not quick
SELECT DISTINCT name FROM grammar_rule JOIN grammar USING (grammar_id)
    GROUP BY grammar_id, name, left_symbol HAVING abs(sum(probability) - 1) > 1e-6;

-- grammar {}: expected sentences of segments, one after the other, found others.
-- not quick
SELECT name FROM grammar LEFT JOIN (
    SELECT grammar_id, min(first_segment) AS low, max(end_segment) AS high,
        bool_and(end_segment > first_segment AND first_segment >= previous) AS ordered
    FROM (SELECT *, lag(end_segment, 1, 0) OVER (
        PARTITION BY grammar_id ORDER BY ordinal) AS previous FROM sentence)
    GROUP BY ALL) USING (grammar_id)
    LEFT JOIN (SELECT grammar_id, count(*) AS n FROM terminal_segment GROUP BY ALL)
    USING (grammar_id)
    WHERE NOT coalesce(ordered, false) OR low < 0 OR high > n;

-- ── Scenes ──────────────────────────────────────────────────────────────────────────────────────

-- scene {}: expected clips of its players, numbered from 0, found others.
-- not quick
SELECT DISTINCT s.name FROM scene s LEFT JOIN scene_player p USING (scene_id) LEFT JOIN (
    SELECT scene_id, player, count(*) AS n, max(ordinal) AS high,
        bool_and(end_frame > start_frame) AS long FROM scene_clip GROUP BY ALL) c
    ON c.scene_id = p.scene_id AND c.player = p.ordinal
    WHERE coalesce(n, 0) = 0 OR high <> n - 1 OR NOT long;

-- scene {}: expected rules about its players, found others.
-- not quick
SELECT DISTINCT s.name FROM scene s JOIN scene_rule r USING (scene_id)
    LEFT JOIN scene_player p ON p.scene_id = r.scene_id AND p.name = r.player
    WHERE p.name IS NULL;

-- scene {}: expected its ball in every frame, or in none, found others.
-- not quick
SELECT name FROM scene JOIN (
    SELECT scene_id, count(*) AS n, count(DISTINCT frame) AS d, max(frame) AS high FROM scene_ball
    GROUP BY ALL) USING (scene_id)
    WHERE n <> n_frames OR d <> n OR high <> n - 1;

-- scene {}: expected captures that were generated, or none, found others.
-- not quick
SELECT DISTINCT s.name FROM scene s JOIN scene_player p USING (scene_id)
    WHERE capture_id <> -1
        AND capture_id NOT IN (SELECT capture_id FROM capture WHERE kind = 'generated');
