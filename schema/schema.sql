-- The store of motiondb: one DuckDB file. A new database is made by this file. The files
-- 000N_WHAT.sql beside it, from 0005 on, bring a database of version N - 1 to version N.
--
-- Rules
-- * Full constraints stand in the first CREATE: DuckDB cannot add them later.
-- * Foreign keys point only at `run`, whose rows are never removed. A child and its parent cannot
--   be deleted in one transaction, so a foreign key to `capture` would forbid removing a capture
--   atomically; `motiondb check` proves instead that every number can be resolved.
-- * Tables with a row a frame or a row a pair have no primary key: each is written by one function
--   in one transaction, and an index would cost more than the table.
-- * Derived tables (below) are replaced as a whole, never edited; every row names its run.
-- * A missing float (NaN) is stored as NULL.
-- * symbol_id -1 is no symbol: NULL of the translation model, the begin or end of a capture.

-- ── Housekeeping ─────────────────────────────────────────────────────────────────────────────

-- schema (the version of the tables), created_by (motiondb's version), next_capture_id, revision (a
-- number that every committed change raises), motion_revision, content_revision and segment_revision
-- (random marks, new with every change of the motions, of anything that can be learned from, or of
-- the segments), log ('open' while
-- changes stand in the log beside the file, else empty), unused_parquet_files (JSON list of paths that
-- are to be told, or missing), lost_log (when the file was changed without its log, or missing).
CREATE TABLE meta (
    key VARCHAR PRIMARY KEY,
    value VARCHAR NOT NULL
);

-- What made a row: the command with its parameters, seed and version.
CREATE TABLE run (
    run_id BIGINT PRIMARY KEY,
    kind VARCHAR NOT NULL,
    parameters VARCHAR NOT NULL,            -- JSON object
    seed BIGINT,
    version VARCHAR NOT NULL,               -- of motiondb
    started VARCHAR NOT NULL,               -- ISO 8601, UTC
    finished VARCHAR                        -- NULL: running, or killed
);

-- ── Catalogue: what the user put in ──────────────────────────────────────────────────────────

-- Parquet files that hold motions and original files of captures, or the scores of their segments
-- (`compact --motions-to`). They are never changed. In other tables, a column NAME_at says which bytes
-- of them a value is that was moved; it is NULL where the value is here.
CREATE TABLE parquet_file (
    file_id BIGINT PRIMARY KEY,
    place VARCHAR NOT NULL,                 -- folder, or URL of one
    name VARCHAR NOT NULL UNIQUE,           -- of the file in there: 'motions-...', 'scores-...'
    n_bytes BIGINT NOT NULL,
    sha256 VARCHAR NOT NULL
);

-- The files as they were, so that what went in can come out bit for bit.
CREATE TABLE source (
    sha256 VARCHAR PRIMARY KEY,             -- of the file, then its skeleton file
    format VARCHAR NOT NULL,
    file_name VARCHAR NOT NULL,
    skeleton_name VARCHAR,                  -- NULL: the file carries its own skeleton
    data BLOB USING COMPRESSION uncompressed NOT NULL,          -- zlib; empty: left out, or moved
    skeleton_data BLOB USING COMPRESSION uncompressed,          -- zlib
    data_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT),     -- or NULL
    skeleton_data_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT)
);

-- A capture's identity: never edited after it was added.
CREATE TABLE capture (
    capture_id BIGINT PRIMARY KEY,          -- never used again after a removal
    name VARCHAR NOT NULL UNIQUE,           -- path below the added folder, without ending
    sha256 VARCHAR NOT NULL UNIQUE,         -- of its source
    format VARCHAR NOT NULL,
    kind VARCHAR NOT NULL CHECK (kind IN ('captured', 'generated')),
    fps DOUBLE NOT NULL CHECK (fps > 0),    -- of the file, or as the sheet says
    n_frames BIGINT NOT NULL CHECK (n_frames >= 0),             -- of the file
    duration DOUBLE NOT NULL CHECK (duration >= 0),             -- seconds
    motion_frames BIGINT NOT NULL CHECK (motion_frames >= 0),   -- at 30 a second
    leg_length DOUBLE NOT NULL,             -- metres
    path VARCHAR NOT NULL,                  -- where the file stood
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    notes VARCHAR[] NOT NULL,               -- what the reader found odd
    motion_notes VARCHAR[] NOT NULL         -- what was mended in the motion
);

-- Performer, licence and every further column of the sheet; may be edited.
CREATE TABLE capture_tag (
    capture_id BIGINT NOT NULL,
    key VARCHAR NOT NULL,
    value VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, key)
);

-- Words as people wrote them; may be edited.
CREATE TABLE caption (
    capture_id BIGINT NOT NULL,
    ordinal INTEGER NOT NULL,
    start_s DOUBLE,                         -- seconds; NULL: from the beginning
    end_s DOUBLE,                           -- seconds; NULL: to the end
    words VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, ordinal)
);

-- Instants of captures, by frames of the motion (30 a second): feet that strike, balls that are
-- caught and released, contacts; may be edited.
CREATE TABLE event (
    capture_id BIGINT NOT NULL,
    frame BIGINT NOT NULL CHECK (frame >= 0),
    name VARCHAR NOT NULL,                  -- 'foot_strike', 'catch', 'release', 'contact', ...
    joint VARCHAR NOT NULL,                 -- of the canonical body; '': nobody said
    other VARCHAR NOT NULL,                 -- what it has to do with; '': nobody said
    PRIMARY KEY (capture_id, frame, name, joint, other)
);

-- The user's own synonyms: `word` is read as `canonical`.
CREATE TABLE synonym (
    word VARCHAR PRIMARY KEY,
    canonical VARCHAR NOT NULL
);

-- The motion on the canonical body at 30 frames a second. A pose has 87 numbers: root position x y z
-- in metres, then the 21 joints' local rotations, each a unit quaternion w x y z; those of captures
-- are multiples of 2^-17. They are packed without loss (motiondb/store/catalogue/captures.py).
CREATE TABLE motion (
    capture_id BIGINT NOT NULL,
    n_frames BIGINT NOT NULL,
    poses BLOB USING COMPRESSION uncompressed NOT NULL,         -- empty: moved
    poses_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT)     -- or NULL
);

-- `capture_id` repeats `other_id`: as a whole, mirrored, or cut out of it (seconds within other).
CREATE TABLE relation (
    capture_id BIGINT NOT NULL,
    other_id BIGINT NOT NULL,
    kind VARCHAR NOT NULL CHECK (kind IN ('same', 'mirror', 'cut')),
    start_s DOUBLE NOT NULL,
    end_s DOUBLE NOT NULL,
    distance DOUBLE NOT NULL,
    PRIMARY KEY (capture_id, other_id, kind)
);

-- What captures lack, as `quality` found it; goes with its capture.
CREATE TABLE capture_quality (
    capture_id BIGINT PRIMARY KEY,
    seconds DOUBLE[] NOT NULL,              -- a number from 0 to 1 for each second
    untold VARCHAR[] NOT NULL,              -- sentences: what cannot be told
    floor DOUBLE NOT NULL,                  -- height in the world of the capture, metres
    flights DOUBLE[] NOT NULL,              -- gravity and its error, m/s2, of each flight in turn
    run_id BIGINT NOT NULL REFERENCES run (run_id)
);

CREATE TABLE finding (
    capture_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    kind VARCHAR NOT NULL,                  -- 'sits', 'hangs', 'jumps', 'frozen', 'rate', ...
    family VARCHAR NOT NULL CHECK (family IN ('needs', 'fault', 'file')),
    start_s DOUBLE NOT NULL,
    end_s DOUBLE NOT NULL,
    measure DOUBLE NOT NULL,                -- in unit
    unit VARCHAR NOT NULL,
    threshold DOUBLE NOT NULL,              -- in unit
    part VARCHAR NOT NULL,                  -- of the body
    sentence VARCHAR NOT NULL,
    place DOUBLE[],                         -- x, y, z, metres, y up; NULL: everywhere
    boxes DOUBLE[] NOT NULL,                -- of each in turn: centre, then whole sizes
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    PRIMARY KEY (capture_id, ordinal)
);

-- From which captures a generated one was made. Name, digest and licence are copied, so that they
-- stay true when the source is removed.
CREATE TABLE generated_source (
    capture_id BIGINT NOT NULL,
    ordinal INTEGER NOT NULL,
    source_name VARCHAR NOT NULL,
    source_sha256 VARCHAR NOT NULL,
    licence VARCHAR NOT NULL,
    PRIMARY KEY (capture_id, ordinal)
);

-- Where every frame of a generated capture comes from.
CREATE TABLE frame_source (
    capture_id BIGINT NOT NULL,
    frame INTEGER NOT NULL,
    source_ordinal INTEGER NOT NULL,        -- in generated_source; -1: drawn from the model
    source_frame DOUBLE NOT NULL,           -- at 30 a second, may lie between frames
    warp DOUBLE NOT NULL,                   -- source frames per frame
    edit VARCHAR NOT NULL                   -- what was done: '', 'blend', 'foot lock', ...
);

-- A capture as it was before a run changed it, so that the run can be undone and captions have a
-- history. The rows of a removed capture are in the schema `trash`, in tables that are made when
-- they are needed and have the columns of those here; `compact` drops them.
CREATE TABLE edit (
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    capture_id BIGINT NOT NULL,
    kind VARCHAR NOT NULL CHECK (kind IN ('added', 'changed', 'removed')),
    name VARCHAR NOT NULL,                  -- before; of an added capture, the name it got
    tags VARCHAR,                           -- JSON object, before; NULL: left alone
    captions VARCHAR,                       -- JSON list of [words, start, end], before
    events VARCHAR,                         -- JSON list of [frame, name, joint, other], before
    PRIMARY KEY (run_id, capture_id)
);

-- Files that `add` could not read; replaced when their folder is added again.
CREATE TABLE faulty_file (
    path VARCHAR PRIMARY KEY,
    problem VARCHAR NOT NULL,
    noted VARCHAR NOT NULL                  -- ISO 8601, UTC
);

-- Files that were added although a capture of another name has their content.
CREATE TABLE same_file (
    path VARCHAR PRIMARY KEY,
    capture_id BIGINT NOT NULL
);

-- Files that `add` has read, so that those that are the same need not be read again.
CREATE TABLE known_file (
    path VARCHAR PRIMARY KEY,               -- absolute
    state VARCHAR NOT NULL,                 -- JSON: size, time and access of it and its skeleton
    options VARCHAR NOT NULL,               -- JSON: version and options that it was read with
    readings VARCHAR NOT NULL               -- JSON: takes, digests, problems and axes up
);

-- ── Derived: what `learn` makes, replaced as a whole ─────────────────────────────────────────

-- One row where `learn` has run: the sizes of everything below.
CREATE TABLE learning (
    run_id BIGINT NOT NULL REFERENCES run (run_id),
    content_revision VARCHAR NOT NULL,      -- of meta, when it was saved
    n_symbols BIGINT NOT NULL,
    max_states BIGINT NOT NULL,
    n_features BIGINT NOT NULL,             -- dimensions of means and covars
    n_coordinates BIGINT NOT NULL,          -- dimensions of the symbol space
    n_clusters BIGINT NOT NULL,
    n_words BIGINT NOT NULL
);

-- Half-open intervals [start_frame, end_frame) of the motion; those of a capture tile it.
CREATE TABLE segment (
    capture_id BIGINT NOT NULL,
    start_frame BIGINT NOT NULL,
    end_frame BIGINT NOT NULL,
    symbol_id BIGINT NOT NULL,              -- the arg-max symbol
    log_likelihood DOUBLE,                  -- of that symbol, nats per frame
    background DOUBLE,                      -- of the background model, nats per frame
    run_id BIGINT NOT NULL
);

-- Log-likelihood of the segments of a capture under every symbol, nats per frame. Where they were
-- moved, they are the bytes of float32 numbers in the same order, little-endian.
CREATE TABLE segment_score (
    capture_id BIGINT NOT NULL,
    scores FLOAT[] NOT NULL,                -- by start_frame, then symbol_id; empty: moved
    run_id BIGINT NOT NULL,
    scores_at STRUCT(file_id BIGINT, start BIGINT, n_bytes BIGINT, crc32 BIGINT)    -- or NULL
);

-- Left-to-right hidden Markov models.
CREATE TABLE symbol (
    symbol_id BIGINT PRIMARY KEY,
    n_states BIGINT NOT NULL,
    cluster_id BIGINT NOT NULL,
    coordinates DOUBLE[] NOT NULL,          -- in the symbol space
    run_id BIGINT NOT NULL
);

CREATE TABLE symbol_state (
    symbol_id BIGINT NOT NULL,
    state BIGINT NOT NULL,
    self_loop DOUBLE,                       -- probability of staying
    means DOUBLE[] NOT NULL,                -- feature units
    covars DOUBLE[] NOT NULL,               -- variances
    run_id BIGINT NOT NULL,
    PRIMARY KEY (symbol_id, state)
);

CREATE TABLE symbol_distance (
    symbol_id BIGINT NOT NULL,
    other_id BIGINT NOT NULL,
    distance DOUBLE,                        -- nats per frame
    variance DOUBLE,                        -- of the distance's estimate
    run_id BIGINT NOT NULL
);

-- Normalised stress of the multidimensional scaling, by number of dimensions.
CREATE TABLE space_stress (
    dimensions BIGINT PRIMARY KEY,
    stress DOUBLE,
    run_id BIGINT NOT NULL
);

-- The Gaussian mixture in the symbol space.
CREATE TABLE cluster (
    cluster_id BIGINT PRIMARY KEY,
    weight DOUBLE,
    mean DOUBLE[] NOT NULL,
    covar DOUBLE[] NOT NULL,                -- row by row
    run_id BIGINT NOT NULL
);

-- The vocabulary, sorted.
CREATE TABLE word (
    word_id BIGINT PRIMARY KEY,
    word VARCHAR NOT NULL UNIQUE,
    count BIGINT NOT NULL,                  -- captions in which it stands
    run_id BIGINT NOT NULL
);

-- t(word | symbol) where it is not 0.
CREATE TABLE translation (
    symbol_id BIGINT NOT NULL,              -- -1: NULL
    word_id BIGINT NOT NULL,
    probability DOUBLE,
    run_id BIGINT NOT NULL
);

-- a(i | j, l, m): word j of m, over NULL and the l symbols.
CREATE TABLE alignment (
    l BIGINT NOT NULL,
    m BIGINT NOT NULL,
    j BIGINT NOT NULL,
    probabilities DOUBLE[] NOT NULL,        -- i = 0 (NULL) ... l
    run_id BIGINT NOT NULL,
    PRIMARY KEY (l, m, j)
);

-- Sum of log P(words | symbols) after every step of expectation-maximisation.
CREATE TABLE association_step (
    step BIGINT PRIMARY KEY,
    log_likelihood DOUBLE,
    run_id BIGINT NOT NULL
);

-- How often `next_id` follows `symbol_id`, where it does (-1: begin and end of a capture).
CREATE TABLE transition_count (
    symbol_id BIGINT NOT NULL,
    next_id BIGINT NOT NULL,
    count DOUBLE,
    run_id BIGINT NOT NULL
);

-- Further values of the models by name: arrays in C order, in pieces of at most 65,536 numbers, or
-- texts in JSON.
CREATE TABLE parameter (
    name VARCHAR NOT NULL,
    piece BIGINT NOT NULL,
    shape BIGINT[],
    numbers DOUBLE[],
    text VARCHAR,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (name, piece),
    CHECK ((numbers IS NULL) = (shape IS NULL)),
    CHECK ((numbers IS NULL) = (text IS NOT NULL))
);

-- ── Grammars: what `grammar learn` makes, a grammar replaced or removed as a whole ───────────

-- A context-free grammar of movements. Its settings and seed are those of its run.
CREATE TABLE grammar (
    grammar_id BIGINT PRIMARY KEY,
    name VARCHAR NOT NULL UNIQUE,
    start_symbol VARCHAR NOT NULL,
    objective DOUBLE,                       -- F of the terminals; NULL: these are motion symbols
    run_id BIGINT NOT NULL REFERENCES run (run_id)
);

-- The captures a grammar was learned from, its takes. Name and digest are copied: the grammar stays
-- when a capture is removed, and finds it again by its digest when it comes back.
CREATE TABLE grammar_source (
    grammar_id BIGINT NOT NULL,
    take BIGINT NOT NULL,
    source_name VARCHAR NOT NULL,
    source_sha256 VARCHAR NOT NULL,
    n_frames BIGINT NOT NULL CHECK (n_frames > 0),              -- at 30 a second
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, take)
);

-- The actions that a grammar orders.
CREATE TABLE terminal (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    name VARCHAR NOT NULL,                  -- a, b, ..., z, aa, ...; s7: motion symbol 7
    symbol_id BIGINT NOT NULL,              -- the motion symbol it is, when learned; -1: none
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal),
    UNIQUE (grammar_id, name)
);

-- Half-open intervals of the takes, by take then start; those of a take tile it.
CREATE TABLE terminal_segment (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,                -- over all takes of the grammar
    take BIGINT NOT NULL,
    start_frame BIGINT NOT NULL,
    end_frame BIGINT NOT NULL,
    terminal BIGINT NOT NULL,               -- ordinal of its terminal
    is_medoid BOOLEAN NOT NULL,             -- the one that stands for its terminal
    run_id BIGINT NOT NULL
);

-- Production rules; a rule's number is its ordinal.
CREATE TABLE grammar_rule (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    left_symbol VARCHAR NOT NULL,
    right_symbols VARCHAR[] NOT NULL,       -- terminals by name, nonterminals; empty: nothing
    probability DOUBLE NOT NULL CHECK (probability >= 0 AND probability <= 1),
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal)
);

-- The sentences the takes were cut into, each with its parse: rules and parses give back the takes'
-- strings exactly. Segments between sentences were left out as errors.
CREATE TABLE sentence (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    first_segment BIGINT NOT NULL,          -- ordinals of terminal_segment, half-open
    end_segment BIGINT NOT NULL,
    rules BIGINT[] NOT NULL,                -- numbers of the rules of its tree, in preorder
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal)
);

-- The ledger of the description: bits of every part.
CREATE TABLE grammar_bits (
    grammar_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    part VARCHAR NOT NULL,
    bits DOUBLE NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (grammar_id, ordinal)
);

-- How a generated capture was derived, so that it can be edited; goes with its grammar or capture.
CREATE TABLE derivation (
    capture_id BIGINT PRIMARY KEY,
    grammar_id BIGINT NOT NULL,
    rules BIGINT[] NOT NULL,                -- numbers of the rules of its tree, in preorder
    clips BIGINT[] NOT NULL,                -- per leaf the ordinal of its terminal_segment
    run_id BIGINT NOT NULL
);

-- ── Scenes: several characters, made by a motion grammar from a tactics diagram ──────────────

-- A scene is kept, replaced and removed as a whole. Diagram and grammar are kept as text, so that a
-- scene can be told, reported and changed without the files that it was made from.
CREATE TABLE scene (
    scene_id BIGINT PRIMARY KEY,
    name VARCHAR NOT NULL UNIQUE,
    diagram VARCHAR NOT NULL,               -- the text of the tactics file
    grammar VARCHAR NOT NULL,               -- the text of the grammar file
    settings VARCHAR NOT NULL,              -- JSON: seed, chains, seconds, weights, ...
    error DOUBLE NOT NULL,                  -- -log P(Z) of what was sampled, before polish
    report VARCHAR NOT NULL,                -- JSON: collisions, feet, times, licences
    n_frames BIGINT NOT NULL CHECK (n_frames > 0),              -- at 30 a second
    run_id BIGINT NOT NULL REFERENCES run (run_id)
);

-- What every player does, and where and when it begins.
CREATE TABLE scene_player (
    scene_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,                -- order of the diagram
    name VARCHAR NOT NULL,
    team VARCHAR NOT NULL,
    rules BIGINT[] NOT NULL,                -- numbers of the rules of the tree, in preorder
    x DOUBLE NOT NULL,                      -- metres
    z DOUBLE NOT NULL,                      -- metres
    heading DOUBLE NOT NULL,                -- radians, from +z towards +x
    delay BIGINT NOT NULL CHECK (delay >= 0),                   -- frames
    capture_id BIGINT NOT NULL,             -- the motion, kept as a capture; -1: not kept
    run_id BIGINT NOT NULL,
    PRIMARY KEY (scene_id, ordinal),
    UNIQUE (scene_id, name)
);

-- The piece of a capture that plays an action. Name and digest are copied: a scene stays when a
-- capture is removed.
CREATE TABLE scene_clip (
    scene_id BIGINT NOT NULL,
    player BIGINT NOT NULL,                 -- ordinal of scene_player
    ordinal BIGINT NOT NULL,                -- place in the action string
    terminal VARCHAR NOT NULL,
    source_name VARCHAR NOT NULL,
    source_sha256 VARCHAR NOT NULL,
    start_frame BIGINT NOT NULL,            -- of the source, half-open
    end_frame BIGINT NOT NULL,
    mirrored BOOLEAN NOT NULL,
    bend DOUBLE NOT NULL,                   -- radians
    stretch DOUBLE NOT NULL,                -- of the steps
    begin_frame BIGINT NOT NULL,            -- of the scene as sampled
    run_id BIGINT NOT NULL,
    PRIMARY KEY (scene_id, player, ordinal)
);

-- How far every rule is from being kept.
CREATE TABLE scene_rule (
    scene_id BIGINT NOT NULL,
    ordinal BIGINT NOT NULL,
    player VARCHAR NOT NULL,
    action VARCHAR NOT NULL,
    clip BIGINT NOT NULL,                   -- ordinal of scene_clip
    kind VARCHAR NOT NULL,
    about VARCHAR NOT NULL,                 -- whom or what
    unit VARCHAR NOT NULL,                  -- m, deg, frames
    before DOUBLE NOT NULL,                 -- as sampled
    after DOUBLE NOT NULL,                  -- after polish
    threshold DOUBLE NOT NULL,
    frame BIGINT NOT NULL,
    kept BOOLEAN NOT NULL,
    run_id BIGINT NOT NULL,
    PRIMARY KEY (scene_id, ordinal)
);

-- The middle of the ball, metres; no rows where nobody has a ball.
CREATE TABLE scene_ball (
    scene_id BIGINT NOT NULL,
    frame BIGINT NOT NULL,
    x DOUBLE NOT NULL,
    y DOUBLE NOT NULL,
    z DOUBLE NOT NULL,
    run_id BIGINT NOT NULL
);
