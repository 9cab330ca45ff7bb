CREATE TABLE acts (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	happened_at TEXT COLLATE "C" NOT NULL,
	operation TEXT COLLATE "C" NOT NULL,
	resource TEXT COLLATE "C" NOT NULL,
	status BIGINT NOT NULL,
	person TEXT COLLATE "C",
	role TEXT COLLATE "C",
	how TEXT COLLATE "C",
	tablet TEXT COLLATE "C",
	address TEXT COLLATE "C",
	reason TEXT COLLATE "C",
	PRIMARY KEY (id)
);
CREATE TABLE campaigns (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	robot TEXT COLLATE "C" NOT NULL,
	summary JSON NOT NULL,
	session_ids JSON NOT NULL,
	archive BYTEA NOT NULL,
	campaign BYTEA NOT NULL,
	PRIMARY KEY (id)
);
CREATE TABLE handed_down (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	plant TEXT COLLATE "C" NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	person TEXT COLLATE "C" NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id)
);
CREATE TABLE jobs (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	request JSON NOT NULL,
	PRIMARY KEY (id)
);
CREATE TABLE links (
	id BIGINT NOT NULL,
	stream BIGINT NOT NULL,
	record TEXT COLLATE "C" NOT NULL,
	record_id BIGINT NOT NULL,
	hash BYTEA NOT NULL,
	PRIMARY KEY (id)
);
CREATE INDEX ix_links_stream ON links (stream, id);
CREATE TABLE people (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (name)
);
CREATE TABLE plant_cells (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (name)
);
CREATE TABLE plant_instruments (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	serial_number TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (serial_number)
);
CREATE TABLE plant_robots (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	serial_number TEXT COLLATE "C" NOT NULL,
	robot TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (serial_number)
);
CREATE TABLE reports (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	subject_id BIGINT NOT NULL,
	revision BIGINT NOT NULL,
	language TEXT COLLATE "C" NOT NULL,
	stated_sha256 TEXT COLLATE "C" NOT NULL,
	page BYTEA NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (kind, subject_id, revision, language)
);
CREATE TABLE request_keys (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	key TEXT COLLATE "C" NOT NULL,
	fingerprint TEXT COLLATE "C" NOT NULL,
	resource TEXT COLLATE "C" NOT NULL,
	resource_id BIGINT NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (key)
);
CREATE TABLE series (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	columns JSON NOT NULL,
	PRIMARY KEY (id)
);
CREATE TABLE sessions (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	role TEXT COLLATE "C" NOT NULL,
	setup JSON NOT NULL,
	plan JSON NOT NULL,
	PRIMARY KEY (id)
);
CREATE TABLE closings (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	closed_as TEXT COLLATE "C" NOT NULL,
	person TEXT COLLATE "C" NOT NULL,
	reason TEXT COLLATE "C" NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (session_id),
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
CREATE INDEX ix_closings_session_id ON closings (session_id, id);
CREATE TABLE credentials (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	person_id BIGINT,
	hash TEXT COLLATE "C" NOT NULL,
	expires_at TEXT COLLATE "C",
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(person_id) REFERENCES people (id)
);
CREATE TABLE deliveries (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	series_id BIGINT NOT NULL,
	first BIGINT NOT NULL,
	count BIGINT NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	UNIQUE (series_id, first),
	FOREIGN KEY(series_id) REFERENCES series (id)
);
CREATE TABLE diagnoses (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	job_id BIGINT NOT NULL,
	campaign_id BIGINT NOT NULL,
	measured_at TEXT COLLATE "C" NOT NULL,
	robot_serial_number TEXT COLLATE "C" NOT NULL,
	summary JSON NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(campaign_id) REFERENCES campaigns (id)
);
CREATE TABLE hand_down_uses (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	handed_down_id BIGINT NOT NULL,
	person TEXT COLLATE "C" NOT NULL,
	note TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(handed_down_id) REFERENCES handed_down (id)
);
CREATE INDEX ix_hand_down_uses_handed_down_id ON hand_down_uses (handed_down_id, id);
CREATE TABLE identifications (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	job_id BIGINT NOT NULL,
	campaign_id BIGINT NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(campaign_id) REFERENCES campaigns (id)
);
CREATE TABLE job_states (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	job_id BIGINT NOT NULL,
	state TEXT COLLATE "C" NOT NULL,
	message TEXT COLLATE "C" NOT NULL,
	result_id BIGINT,
	PRIMARY KEY (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id)
);
CREATE INDEX ix_job_states_job_id ON job_states (job_id, id);
CREATE TABLE notes (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	text TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
CREATE INDEX ix_notes_session_id ON notes (session_id, id);
CREATE TABLE person_states (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	person_id BIGINT NOT NULL,
	role TEXT COLLATE "C" NOT NULL,
	active BIGINT NOT NULL,
	by TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(person_id) REFERENCES people (id)
);
CREATE TABLE plant_branches (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	cell_id BIGINT NOT NULL,
	parent_id BIGINT,
	after_link BIGINT NOT NULL,
	person TEXT COLLATE "C" NOT NULL,
	reason TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(cell_id) REFERENCES plant_cells (id),
	FOREIGN KEY(parent_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_branches_cell_id ON plant_branches (cell_id, id);
CREATE TABLE plant_hand_downs (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	cell_id BIGINT NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	person TEXT COLLATE "C" NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(cell_id) REFERENCES plant_cells (id)
);
CREATE INDEX ix_plant_hand_downs_cell_id ON plant_hand_downs (cell_id, id);
CREATE TABLE plant_visits (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	cell_id BIGINT NOT NULL,
	outcome TEXT COLLATE "C" NOT NULL,
	sentence TEXT COLLATE "C" NOT NULL,
	collected BIGINT NOT NULL,
	newest BIGINT,
	head TEXT COLLATE "C",
	fork BIGINT,
	clock_offset_s FLOAT,
	clock_bound_s FLOAT,
	version TEXT COLLATE "C",
	cell_schema TEXT COLLATE "C",
	PRIMARY KEY (id),
	FOREIGN KEY(cell_id) REFERENCES plant_cells (id)
);
CREATE INDEX ix_plant_visits_cell_id ON plant_visits (cell_id, id);
CREATE TABLE readings (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	config BIGINT,
	nest BIGINT NOT NULL,
	time_s FLOAT NOT NULL,
	supersedes BIGINT,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	UNIQUE (supersedes),
	FOREIGN KEY(supersedes) REFERENCES readings (id)
);
CREATE INDEX ix_readings_counted ON readings (session_id, kind, supersedes);
CREATE INDEX ix_readings_place ON readings (session_id, config, nest, id);
CREATE INDEX ix_readings_session_id ON readings (session_id, id);
CREATE TABLE session_states (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	state TEXT COLLATE "C" NOT NULL,
	reason TEXT COLLATE "C" NOT NULL,
	person TEXT COLLATE "C",
	PRIMARY KEY (id),
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
CREATE INDEX ix_session_states_session_id ON session_states (session_id, id);
CREATE TABLE added_stops (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	diagnosis_id BIGINT,
	person TEXT COLLATE "C" NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(diagnosis_id) REFERENCES diagnoses (id)
);
CREATE INDEX ix_added_stops_session_id ON added_stops (session_id, id);
CREATE TABLE events (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	session_id BIGINT,
	job_id BIGINT,
	reading_id BIGINT,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(reading_id) REFERENCES readings (id)
);
CREATE INDEX ix_events_job_id ON events (job_id, kind, id);
CREATE INDEX ix_events_session_id ON events (session_id, kind, id);
CREATE TABLE models (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	identification_id BIGINT,
	diagnosis_id BIGINT,
	robot TEXT COLLATE "C" NOT NULL,
	document JSON NOT NULL,
	handed_down_id BIGINT,
	accepted_by TEXT COLLATE "C",
	PRIMARY KEY (id),
	CONSTRAINT models_one_origin CHECK ((CASE WHEN identification_id IS NULL THEN 0 ELSE 1 END) + (CASE WHEN diagnosis_id IS NULL THEN 0 ELSE 1 END) + (CASE WHEN handed_down_id IS NULL THEN 0 ELSE 1 END) = 1),
	FOREIGN KEY(identification_id) REFERENCES identifications (id),
	FOREIGN KEY(diagnosis_id) REFERENCES diagnoses (id),
	FOREIGN KEY(handed_down_id) REFERENCES handed_down (id)
);
CREATE UNIQUE INDEX uq_models_handed_down_id ON models (handed_down_id);
CREATE TABLE plant_certificates (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	branch_id BIGINT NOT NULL,
	link BIGINT NOT NULL,
	what TEXT COLLATE "C" NOT NULL,
	serial_number TEXT COLLATE "C" NOT NULL,
	certificate TEXT COLLATE "C" NOT NULL,
	expires TEXT COLLATE "C" NOT NULL,
	stated_on TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_certificates_of ON plant_certificates (serial_number, branch_id, what, id);
CREATE TABLE plant_days (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	branch_id BIGINT NOT NULL,
	session_id BIGINT NOT NULL,
	measured_on TEXT COLLATE "C" NOT NULL,
	robot_serial_number TEXT COLLATE "C" NOT NULL,
	instrument_serial_number TEXT COLLATE "C" NOT NULL,
	readings BIGINT NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_days_instrument ON plant_days (instrument_serial_number, measured_on);
CREATE INDEX ix_plant_days_robot ON plant_days (robot_serial_number, measured_on);
CREATE INDEX ix_plant_days_session_id ON plant_days (branch_id, session_id);
CREATE TABLE plant_hand_down_states (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	hand_down_id BIGINT NOT NULL,
	state TEXT COLLATE "C" NOT NULL,
	sentence TEXT COLLATE "C" NOT NULL,
	number_in_cell BIGINT,
	PRIMARY KEY (id),
	FOREIGN KEY(hand_down_id) REFERENCES plant_hand_downs (id)
);
CREATE INDEX ix_plant_hand_down_states_hand_down_id ON plant_hand_down_states (hand_down_id, id);
CREATE TABLE plant_journal (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	branch_id BIGINT NOT NULL,
	link BIGINT NOT NULL,
	stream BIGINT NOT NULL,
	record TEXT COLLATE "C" NOT NULL,
	record_id BIGINT NOT NULL,
	hash BYTEA NOT NULL,
	content TEXT COLLATE "C",
	verified BIGINT NOT NULL,
	PRIMARY KEY (id),
	CONSTRAINT uq_plant_journal_link UNIQUE (branch_id, link),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_journal_record ON plant_journal (branch_id, record, record_id);
CREATE INDEX ix_plant_journal_stream ON plant_journal (branch_id, stream, link);
CREATE TABLE plant_results (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	branch_id BIGINT NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	link BIGINT NOT NULL,
	record_id BIGINT NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	robot TEXT COLLATE "C" NOT NULL,
	robot_serial_number TEXT COLLATE "C" NOT NULL,
	instrument_serial_number TEXT COLLATE "C" NOT NULL,
	measured_on TEXT COLLATE "C" NOT NULL,
	clock_offset_s FLOAT,
	PRIMARY KEY (id),
	CONSTRAINT uq_plant_results_record UNIQUE (branch_id, kind, record_id),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_results_instrument ON plant_results (instrument_serial_number, measured_on, id);
CREATE INDEX ix_plant_results_kind ON plant_results (kind, id);
CREATE INDEX ix_plant_results_robot ON plant_results (robot_serial_number, measured_on, id);
CREATE TABLE plant_sessions (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	branch_id BIGINT NOT NULL,
	session_id BIGINT NOT NULL,
	robot TEXT COLLATE "C" NOT NULL,
	robot_serial_number TEXT COLLATE "C" NOT NULL,
	instrument_serial_number TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_sessions_session_id ON plant_sessions (branch_id, session_id, id);
CREATE TABLE plant_told (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	branch_id BIGINT NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	link BIGINT NOT NULL,
	record_id BIGINT NOT NULL,
	robot_serial_number TEXT COLLATE "C" NOT NULL,
	measured_on TEXT COLLATE "C" NOT NULL,
	verdict TEXT COLLATE "C" NOT NULL,
	figure_mm FLOAT,
	limit_mm FLOAT,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	CONSTRAINT uq_plant_told_link UNIQUE (branch_id, link),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_told_record ON plant_told (branch_id, kind, record_id);
CREATE INDEX ix_plant_told_robot ON plant_told (robot_serial_number, kind, measured_on, id);
CREATE TABLE revocations (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	credential_id BIGINT NOT NULL,
	by TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(credential_id) REFERENCES credentials (id)
);
CREATE INDEX ix_revocations_credential_id ON revocations (credential_id);
CREATE TABLE session_entries (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	step_id TEXT COLLATE "C" NOT NULL,
	kind TEXT COLLATE "C" NOT NULL,
	key TEXT COLLATE "C",
	document JSON NOT NULL,
	reading_id BIGINT,
	PRIMARY KEY (id),
	CONSTRAINT uq_session_entries_key UNIQUE (session_id, key),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(reading_id) REFERENCES readings (id)
);
CREATE INDEX ix_session_entries_kind ON session_entries (session_id, kind, step_id);
CREATE INDEX ix_session_entries_session_id ON session_entries (session_id, id);
CREATE TABLE act_answers (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	session_id BIGINT NOT NULL,
	entry_id BIGINT,
	key TEXT COLLATE "C" NOT NULL,
	fingerprint TEXT COLLATE "C" NOT NULL,
	sentence TEXT COLLATE "C" NOT NULL,
	PRIMARY KEY (id),
	CONSTRAINT uq_act_answers_key UNIQUE (session_id, key),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(entry_id) REFERENCES session_entries (id)
);
CREATE TABLE corrections (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	job_id BIGINT NOT NULL,
	model_id BIGINT NOT NULL,
	name TEXT COLLATE "C" NOT NULL,
	original_sha256 TEXT COLLATE "C" NOT NULL,
	corrected_sha256 TEXT COLLATE "C" NOT NULL,
	asked JSON NOT NULL,
	document JSON NOT NULL,
	targets BYTEA NOT NULL,
	file BYTEA NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(model_id) REFERENCES models (id)
);
CREATE INDEX ix_corrections_model_id ON corrections (model_id, id);
CREATE TABLE validations (
	id BIGINT NOT NULL,
	recorded_at TEXT COLLATE "C" NOT NULL,
	job_id BIGINT NOT NULL,
	model_id BIGINT NOT NULL,
	campaign_id BIGINT NOT NULL,
	document JSON NOT NULL,
	PRIMARY KEY (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(model_id) REFERENCES models (id),
	FOREIGN KEY(campaign_id) REFERENCES campaigns (id)
)
