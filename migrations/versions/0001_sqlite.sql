CREATE TABLE acts (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	happened_at TEXT NOT NULL,
	operation TEXT NOT NULL,
	resource TEXT NOT NULL,
	status INTEGER NOT NULL,
	person TEXT,
	role TEXT,
	how TEXT,
	tablet TEXT,
	address TEXT,
	reason TEXT
);
CREATE TABLE campaigns (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	name TEXT NOT NULL,
	robot TEXT NOT NULL,
	summary JSON NOT NULL,
	session_ids JSON NOT NULL,
	archive BLOB NOT NULL,
	campaign BLOB NOT NULL
);
CREATE TABLE handed_down (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	plant TEXT NOT NULL,
	kind TEXT NOT NULL,
	name TEXT NOT NULL,
	person TEXT NOT NULL,
	document JSON NOT NULL
);
CREATE TABLE jobs (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	kind TEXT NOT NULL,
	request JSON NOT NULL
);
CREATE TABLE links (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	stream INTEGER NOT NULL,
	record TEXT NOT NULL,
	record_id INTEGER NOT NULL,
	hash BLOB NOT NULL
);
CREATE INDEX ix_links_stream ON links (stream, id);
CREATE TABLE people (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	name TEXT NOT NULL,
	UNIQUE (name)
);
CREATE TABLE plant_cells (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	name TEXT NOT NULL,
	UNIQUE (name)
);
CREATE TABLE plant_instruments (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	serial_number TEXT NOT NULL,
	UNIQUE (serial_number)
);
CREATE TABLE plant_robots (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	serial_number TEXT NOT NULL,
	robot TEXT NOT NULL,
	UNIQUE (serial_number)
);
CREATE TABLE reports (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	kind TEXT NOT NULL,
	subject_id INTEGER NOT NULL,
	revision INTEGER NOT NULL,
	language TEXT NOT NULL,
	stated_sha256 TEXT NOT NULL,
	page BLOB NOT NULL,
	UNIQUE (kind, subject_id, revision, language)
);
CREATE TABLE request_keys (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	"key" TEXT NOT NULL,
	fingerprint TEXT NOT NULL,
	resource TEXT NOT NULL,
	resource_id INTEGER NOT NULL,
	UNIQUE ("key")
);
CREATE TABLE series (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	name TEXT NOT NULL,
	columns JSON NOT NULL
);
CREATE TABLE sessions (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	name TEXT NOT NULL,
	role TEXT NOT NULL,
	setup JSON NOT NULL,
	"plan" JSON NOT NULL
);
CREATE TABLE closings (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	closed_as TEXT NOT NULL,
	person TEXT NOT NULL,
	reason TEXT NOT NULL,
	document JSON NOT NULL,
	UNIQUE (session_id),
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
CREATE INDEX ix_closings_session_id ON closings (session_id, id);
CREATE TABLE credentials (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	kind TEXT NOT NULL,
	person_id INTEGER,
	hash TEXT NOT NULL,
	expires_at TEXT,
	document JSON NOT NULL,
	FOREIGN KEY(person_id) REFERENCES people (id)
);
CREATE TABLE deliveries (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	series_id INTEGER NOT NULL,
	first INTEGER NOT NULL,
	count INTEGER NOT NULL,
	document JSON NOT NULL,
	UNIQUE (series_id, first),
	FOREIGN KEY(series_id) REFERENCES series (id)
);
CREATE TABLE diagnoses (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	job_id INTEGER NOT NULL,
	campaign_id INTEGER NOT NULL,
	measured_at TEXT NOT NULL,
	robot_serial_number TEXT NOT NULL,
	summary JSON NOT NULL,
	document JSON NOT NULL,
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(campaign_id) REFERENCES campaigns (id)
);
CREATE TABLE hand_down_uses (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	handed_down_id INTEGER NOT NULL,
	person TEXT NOT NULL,
	note TEXT NOT NULL,
	FOREIGN KEY(handed_down_id) REFERENCES handed_down (id)
);
CREATE INDEX ix_hand_down_uses_handed_down_id ON hand_down_uses (handed_down_id, id);
CREATE TABLE identifications (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	job_id INTEGER NOT NULL,
	campaign_id INTEGER NOT NULL,
	document JSON NOT NULL,
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(campaign_id) REFERENCES campaigns (id)
);
CREATE TABLE job_states (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	job_id INTEGER NOT NULL,
	state TEXT NOT NULL,
	message TEXT NOT NULL,
	result_id INTEGER,
	FOREIGN KEY(job_id) REFERENCES jobs (id)
);
CREATE INDEX ix_job_states_job_id ON job_states (job_id, id);
CREATE TABLE notes (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	text TEXT NOT NULL,
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
CREATE INDEX ix_notes_session_id ON notes (session_id, id);
CREATE TABLE person_states (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	person_id INTEGER NOT NULL,
	role TEXT NOT NULL,
	active INTEGER NOT NULL,
	"by" TEXT NOT NULL,
	FOREIGN KEY(person_id) REFERENCES people (id)
);
CREATE TABLE plant_branches (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	cell_id INTEGER NOT NULL,
	parent_id INTEGER,
	after_link INTEGER NOT NULL,
	person TEXT NOT NULL,
	reason TEXT NOT NULL,
	FOREIGN KEY(cell_id) REFERENCES plant_cells (id),
	FOREIGN KEY(parent_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_branches_cell_id ON plant_branches (cell_id, id);
CREATE TABLE plant_hand_downs (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	cell_id INTEGER NOT NULL,
	kind TEXT NOT NULL,
	name TEXT NOT NULL,
	person TEXT NOT NULL,
	document JSON NOT NULL,
	FOREIGN KEY(cell_id) REFERENCES plant_cells (id)
);
CREATE INDEX ix_plant_hand_downs_cell_id ON plant_hand_downs (cell_id, id);
CREATE TABLE plant_visits (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	cell_id INTEGER NOT NULL,
	outcome TEXT NOT NULL,
	sentence TEXT NOT NULL,
	collected INTEGER NOT NULL,
	newest INTEGER,
	head TEXT,
	fork INTEGER,
	clock_offset_s FLOAT,
	clock_bound_s FLOAT,
	version TEXT,
	cell_schema TEXT,
	FOREIGN KEY(cell_id) REFERENCES plant_cells (id)
);
CREATE INDEX ix_plant_visits_cell_id ON plant_visits (cell_id, id);
CREATE TABLE readings (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	kind TEXT NOT NULL,
	config INTEGER,
	nest INTEGER NOT NULL,
	time_s FLOAT NOT NULL,
	supersedes INTEGER,
	document JSON NOT NULL,
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	UNIQUE (supersedes),
	FOREIGN KEY(supersedes) REFERENCES readings (id)
);
CREATE INDEX ix_readings_counted ON readings (session_id, kind, supersedes);
CREATE INDEX ix_readings_place ON readings (session_id, config, nest, id);
CREATE INDEX ix_readings_session_id ON readings (session_id, id);
CREATE TABLE session_states (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	state TEXT NOT NULL,
	reason TEXT NOT NULL,
	person TEXT,
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
CREATE INDEX ix_session_states_session_id ON session_states (session_id, id);
CREATE TABLE added_stops (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	diagnosis_id INTEGER,
	person TEXT NOT NULL,
	document JSON NOT NULL,
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(diagnosis_id) REFERENCES diagnoses (id)
);
CREATE INDEX ix_added_stops_session_id ON added_stops (session_id, id);
CREATE TABLE events (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	kind TEXT NOT NULL,
	session_id INTEGER,
	job_id INTEGER,
	reading_id INTEGER,
	document JSON NOT NULL,
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(reading_id) REFERENCES readings (id)
);
CREATE INDEX ix_events_job_id ON events (job_id, kind, id);
CREATE INDEX ix_events_session_id ON events (session_id, kind, id);
CREATE TABLE models (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	identification_id INTEGER,
	diagnosis_id INTEGER,
	robot TEXT NOT NULL,
	document JSON NOT NULL,
	handed_down_id INTEGER,
	accepted_by TEXT,
	CONSTRAINT models_one_origin CHECK ((CASE WHEN identification_id IS NULL THEN 0 ELSE 1 END) + (CASE WHEN diagnosis_id IS NULL THEN 0 ELSE 1 END) + (CASE WHEN handed_down_id IS NULL THEN 0 ELSE 1 END) = 1),
	FOREIGN KEY(identification_id) REFERENCES identifications (id),
	FOREIGN KEY(diagnosis_id) REFERENCES diagnoses (id),
	FOREIGN KEY(handed_down_id) REFERENCES handed_down (id)
);
CREATE UNIQUE INDEX uq_models_handed_down_id ON models (handed_down_id);
CREATE TABLE plant_certificates (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	branch_id INTEGER NOT NULL,
	link INTEGER NOT NULL,
	what TEXT NOT NULL,
	serial_number TEXT NOT NULL,
	certificate TEXT NOT NULL,
	expires TEXT NOT NULL,
	stated_on TEXT NOT NULL,
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_certificates_of ON plant_certificates (serial_number, branch_id, what, id);
CREATE TABLE plant_days (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	branch_id INTEGER NOT NULL,
	session_id INTEGER NOT NULL,
	measured_on TEXT NOT NULL,
	robot_serial_number TEXT NOT NULL,
	instrument_serial_number TEXT NOT NULL,
	readings INTEGER NOT NULL,
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_days_instrument ON plant_days (instrument_serial_number, measured_on);
CREATE INDEX ix_plant_days_robot ON plant_days (robot_serial_number, measured_on);
CREATE INDEX ix_plant_days_session_id ON plant_days (branch_id, session_id);
CREATE TABLE plant_hand_down_states (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	hand_down_id INTEGER NOT NULL,
	state TEXT NOT NULL,
	sentence TEXT NOT NULL,
	number_in_cell INTEGER,
	FOREIGN KEY(hand_down_id) REFERENCES plant_hand_downs (id)
);
CREATE INDEX ix_plant_hand_down_states_hand_down_id ON plant_hand_down_states (hand_down_id, id);
CREATE TABLE plant_journal (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	branch_id INTEGER NOT NULL,
	link INTEGER NOT NULL,
	stream INTEGER NOT NULL,
	record TEXT NOT NULL,
	record_id INTEGER NOT NULL,
	hash BLOB NOT NULL,
	content TEXT,
	verified INTEGER NOT NULL,
	CONSTRAINT uq_plant_journal_link UNIQUE (branch_id, link),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_journal_record ON plant_journal (branch_id, record, record_id);
CREATE INDEX ix_plant_journal_stream ON plant_journal (branch_id, stream, link);
CREATE TABLE plant_results (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	branch_id INTEGER NOT NULL,
	kind TEXT NOT NULL,
	link INTEGER NOT NULL,
	record_id INTEGER NOT NULL,
	name TEXT NOT NULL,
	robot TEXT NOT NULL,
	robot_serial_number TEXT NOT NULL,
	instrument_serial_number TEXT NOT NULL,
	measured_on TEXT NOT NULL,
	clock_offset_s FLOAT,
	CONSTRAINT uq_plant_results_record UNIQUE (branch_id, kind, record_id),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_results_instrument ON plant_results (instrument_serial_number, measured_on, id);
CREATE INDEX ix_plant_results_kind ON plant_results (kind, id);
CREATE INDEX ix_plant_results_robot ON plant_results (robot_serial_number, measured_on, id);
CREATE TABLE plant_sessions (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	branch_id INTEGER NOT NULL,
	session_id INTEGER NOT NULL,
	robot TEXT NOT NULL,
	robot_serial_number TEXT NOT NULL,
	instrument_serial_number TEXT NOT NULL,
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_sessions_session_id ON plant_sessions (branch_id, session_id, id);
CREATE TABLE plant_told (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	branch_id INTEGER NOT NULL,
	kind TEXT NOT NULL,
	link INTEGER NOT NULL,
	record_id INTEGER NOT NULL,
	robot_serial_number TEXT NOT NULL,
	measured_on TEXT NOT NULL,
	verdict TEXT NOT NULL,
	figure_mm FLOAT,
	limit_mm FLOAT,
	document JSON NOT NULL,
	CONSTRAINT uq_plant_told_link UNIQUE (branch_id, link),
	FOREIGN KEY(branch_id) REFERENCES plant_branches (id)
);
CREATE INDEX ix_plant_told_record ON plant_told (branch_id, kind, record_id);
CREATE INDEX ix_plant_told_robot ON plant_told (robot_serial_number, kind, measured_on, id);
CREATE TABLE revocations (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	credential_id INTEGER NOT NULL,
	"by" TEXT NOT NULL,
	FOREIGN KEY(credential_id) REFERENCES credentials (id)
);
CREATE INDEX ix_revocations_credential_id ON revocations (credential_id);
CREATE TABLE session_entries (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	step_id TEXT NOT NULL,
	kind TEXT NOT NULL,
	"key" TEXT,
	document JSON NOT NULL,
	reading_id INTEGER,
	CONSTRAINT uq_session_entries_key UNIQUE (session_id, "key"),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(reading_id) REFERENCES readings (id)
);
CREATE INDEX ix_session_entries_kind ON session_entries (session_id, kind, step_id);
CREATE INDEX ix_session_entries_session_id ON session_entries (session_id, id);
CREATE TABLE act_answers (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	session_id INTEGER NOT NULL,
	entry_id INTEGER,
	"key" TEXT NOT NULL,
	fingerprint TEXT NOT NULL,
	sentence TEXT NOT NULL,
	CONSTRAINT uq_act_answers_key UNIQUE (session_id, "key"),
	FOREIGN KEY(session_id) REFERENCES sessions (id),
	FOREIGN KEY(entry_id) REFERENCES session_entries (id)
);
CREATE TABLE corrections (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	job_id INTEGER NOT NULL,
	model_id INTEGER NOT NULL,
	name TEXT NOT NULL,
	original_sha256 TEXT NOT NULL,
	corrected_sha256 TEXT NOT NULL,
	asked JSON NOT NULL,
	document JSON NOT NULL,
	targets BLOB NOT NULL,
	file BLOB NOT NULL,
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(model_id) REFERENCES models (id)
);
CREATE INDEX ix_corrections_model_id ON corrections (model_id, id);
CREATE TABLE validations (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT,
	recorded_at TEXT NOT NULL,
	job_id INTEGER NOT NULL,
	model_id INTEGER NOT NULL,
	campaign_id INTEGER NOT NULL,
	document JSON NOT NULL,
	FOREIGN KEY(job_id) REFERENCES jobs (id),
	FOREIGN KEY(model_id) REFERENCES models (id),
	FOREIGN KEY(campaign_id) REFERENCES campaigns (id)
)
