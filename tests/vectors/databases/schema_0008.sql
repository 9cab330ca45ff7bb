BEGIN TRANSACTION;
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
INSERT INTO "added_stops" VALUES(1,'2026-11-22T17:41:51.016+00:00',3,NULL,'Ada','[{"config": 11, "joints_rad": [-1.166881122304629, 0.7842638323709402, -0.03150691943289363, -2.4677785814246995, -1.1060728262120585, 2.690529207836934], "nest": 1, "repeat_of": null}]');
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO "alembic_version" VALUES('0008');
CREATE TABLE ballbar_answers (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	session_id INTEGER NOT NULL, 
	entry_id INTEGER, 
	"key" TEXT NOT NULL, 
	fingerprint TEXT NOT NULL, 
	sentence TEXT NOT NULL, 
	CONSTRAINT uq_ballbar_answers_key UNIQUE (session_id, "key"), 
	FOREIGN KEY(session_id) REFERENCES sessions (id), 
	FOREIGN KEY(entry_id) REFERENCES ballbar_entries (id)
);
INSERT INTO "ballbar_answers" VALUES(1,'2026-11-22T17:41:51.027+00:00',4,1,'k1','f','The session has begun.');
CREATE TABLE ballbar_entries (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	session_id INTEGER NOT NULL, 
	step_id TEXT NOT NULL, 
	kind TEXT NOT NULL, 
	"key" TEXT, 
	document JSON NOT NULL, 
	CONSTRAINT uq_ballbar_entries_key UNIQUE (session_id, "key"), 
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
INSERT INTO "ballbar_entries" VALUES(1,'2026-11-22T17:41:51.021+00:00',4,'','control','k1','{"step_id": "", "kind": "control", "time_s": 1.0, "person": "Eva", "tablet": "one", "key": "k1", "text": "running: Eva started the session.", "length": null, "arrival": null, "precalibration": null, "suspicion": null, "identity": null}');
INSERT INTO "ballbar_entries" VALUES(2,'2026-11-22T17:41:51.040+00:00',4,'','control',NULL,'{"step_id": "", "kind": "control", "time_s": 2.0, "person": null, "tablet": null, "key": null, "text": "The ballbar answers with serial number L20042.", "length": null, "arrival": null, "precalibration": null, "suspicion": null, "identity": {"device": "ballbar", "finding": "first", "serial": "L20042", "expected": "", "person": null}}');
INSERT INTO "ballbar_entries" VALUES(3,'2026-11-22T17:41:51.044+00:00',4,'tool/initialise','shown',NULL,'{"step_id": "tool/initialise", "kind": "shown", "time_s": 3.0, "person": "Eva", "tablet": "one", "key": null, "text": "", "length": null, "arrival": null, "precalibration": null, "suspicion": null, "identity": null}');
INSERT INTO "ballbar_entries" VALUES(4,'2026-11-22T17:41:51.047+00:00',4,'tool/initialise','measured',NULL,'{"step_id": "tool/initialise", "kind": "measured", "time_s": 60.0, "person": "Eva", "tablet": "one", "key": null, "text": "", "length": {"length_mm": 150.0, "deviation_mm": 0.1, "zero_mm": 0.0, "standard_uncertainty_mm": 0.0017, "spread_mm": 0.001, "samples": 20, "initialisation": 1, "by_hand": false, "temperature_c": 23.0, "instrument_serial": "L20042", "certificate": "report 7", "certificate_expires": "2027-01-31", "time_s": 60.0}, "arrival": null, "precalibration": null, "suspicion": null, "identity": null}');
INSERT INTO "ballbar_entries" VALUES(5,'2026-11-22T17:41:51.051+00:00',4,'','control',NULL,'{"step_id": "", "kind": "control", "time_s": 61.0, "person": null, "tablet": null, "key": null, "text": "zero_lost", "length": null, "arrival": null, "precalibration": null, "suspicion": null, "identity": null}');
INSERT INTO "ballbar_entries" VALUES(6,'2026-11-22T17:41:51.056+00:00',4,'','control','k2','{"step_id": "", "kind": "control", "time_s": 62.0, "person": "Ada", "tablet": "two", "key": "k2", "text": "hand_over", "length": null, "arrival": null, "precalibration": null, "suspicion": null, "identity": null}');
INSERT INTO "ballbar_entries" VALUES(7,'2026-11-22T17:41:51.060+00:00',4,'','control','k3','{"step_id": "", "kind": "control", "time_s": 63.0, "person": "Ada", "tablet": "two", "key": "k3", "text": "paused: Lunch: an hour.", "length": null, "arrival": null, "precalibration": null, "suspicion": null, "identity": null}');
CREATE TABLE campaigns (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	name TEXT NOT NULL, 
	robot TEXT NOT NULL, 
	summary JSON NOT NULL, 
	session_ids JSON NOT NULL, 
	archive BLOB NOT NULL
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
CREATE TABLE events (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	kind TEXT NOT NULL, 
	session_id INTEGER, 
	job_id INTEGER, 
	document JSON NOT NULL, 
	FOREIGN KEY(session_id) REFERENCES sessions (id), 
	FOREIGN KEY(job_id) REFERENCES jobs (id)
);
INSERT INTO "events" VALUES(1,'2026-11-22T17:41:50.259+00:00','session.state',1,NULL,'{"state": "planned", "reason": "The plan is stored; nothing has moved.", "person": null}');
INSERT INTO "events" VALUES(2,'2026-11-22T17:41:50.277+00:00','session.state',1,NULL,'{"state": "awaiting_confirmation", "reason": "The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?", "person": null}');
INSERT INTO "events" VALUES(3,'2026-11-22T17:41:50.284+00:00','session.progress',1,NULL,'{"done": 0, "skipped": 0, "planned": 3, "elapsed_s": 0.0, "remaining_s": null, "doing": "waiting for a person"}');
INSERT INTO "events" VALUES(4,'2026-11-22T17:41:50.288+00:00','session.state',1,NULL,'{"state": "running", "reason": "Eva had the session go on.", "person": "Eva"}');
INSERT INTO "events" VALUES(5,'2026-11-22T17:41:50.296+00:00','session.progress',1,NULL,'{"done": 0, "skipped": 0, "planned": 3, "elapsed_s": 0.0, "remaining_s": null, "doing": "making the instruments ready"}');
INSERT INTO "events" VALUES(6,'2026-11-22T17:41:50.300+00:00','session.identity',1,NULL,'{"device": "tracker", "finding": "first", "serial": "390001", "expected": "", "person": null}');
INSERT INTO "events" VALUES(7,'2026-11-22T17:41:50.304+00:00','session.note',1,NULL,'{"text": "The tracker is Leica AT401, serial 390001, firmware 3.8."}');
INSERT INTO "events" VALUES(8,'2026-11-22T17:41:50.308+00:00','session.identity',1,NULL,'{"device": "robot", "finding": "first", "serial": "120-1", "expected": "", "person": null}');
INSERT INTO "events" VALUES(9,'2026-11-22T17:41:50.313+00:00','session.note',1,NULL,'{"text": "The robot is ABB IRB 120, serial 120-1, firmware 6.08."}');
INSERT INTO "events" VALUES(10,'2026-11-22T17:41:50.316+00:00','session.note',1,NULL,'{"text": "The robot was told to move at 500 mm/s and 20 deg/s at most, and cannot be asked whether it keeps to that."}');
INSERT INTO "events" VALUES(11,'2026-11-22T17:41:50.323+00:00','session.progress',1,NULL,'{"done": 0, "skipped": 0, "planned": 3, "elapsed_s": 0.0, "remaining_s": null, "doing": "finding the tracker''s place in the world"}');
INSERT INTO "events" VALUES(12,'2026-11-22T17:41:50.393+00:00','session.reading',1,NULL,'{"reading_id": 1, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1052.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(13,'2026-11-22T17:41:50.399+00:00','session.reading',1,NULL,'{"reading_id": 2, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1053.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(14,'2026-11-22T17:41:50.406+00:00','session.reading',1,NULL,'{"reading_id": 3, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1055.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(15,'2026-11-22T17:41:50.411+00:00','session.reading',1,NULL,'{"reading_id": 4, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1056.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(16,'2026-11-22T17:41:50.420+00:00','session.reading',1,NULL,'{"reading_id": 5, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1058.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(17,'2026-11-22T17:41:50.423+00:00','session.reading',1,NULL,'{"reading_id": 6, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1059.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(18,'2026-11-22T17:41:50.429+00:00','session.registered',1,NULL,'{"rms_mm": 2.6254850544756925e-13, "two_face_mm": null}');
INSERT INTO "events" VALUES(19,'2026-11-22T17:41:50.436+00:00','session.note',1,NULL,'{"text": "The tracker''s scale agrees with the certified lengths: -0.0 ppm (u = 1.8 ppm)."}');
INSERT INTO "events" VALUES(20,'2026-11-22T17:41:50.438+00:00','session.progress',1,NULL,'{"done": 0, "skipped": 0, "planned": 3, "elapsed_s": 59.0, "remaining_s": null, "doing": "looking at the fixed nests"}');
INSERT INTO "events" VALUES(21,'2026-11-22T17:41:50.447+00:00','session.reading',1,NULL,'{"reading_id": 7, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1061.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(22,'2026-11-22T17:41:50.453+00:00','session.reading',1,NULL,'{"reading_id": 8, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1063.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(23,'2026-11-22T17:41:50.459+00:00','session.reading',1,NULL,'{"reading_id": 9, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1065.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(24,'2026-11-22T17:41:50.465+00:00','session.progress',1,NULL,'{"done": 0, "skipped": 0, "planned": 3, "elapsed_s": 65.0, "remaining_s": null, "doing": "measuring configuration 1"}');
INSERT INTO "events" VALUES(25,'2026-11-22T17:41:50.476+00:00','session.reading',1,NULL,'{"reading_id": 10, "kind": "point", "supersedes": null, "reading": {"config": 1, "nest": 1, "commanded_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "reported_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1074.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1378.7820983216018, 1466.1745914894477, -381.52523986964144], "position_world_mm": [694.5767607633579, -54.48320661771845, 114.07272073957677], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(26,'2026-11-22T17:41:50.478+00:00','session.progress',1,NULL,'{"done": 1, "skipped": 0, "planned": 3, "elapsed_s": 74.5, "remaining_s": 19.0, "doing": "measuring configuration 2"}');
INSERT INTO "events" VALUES(27,'2026-11-22T17:41:50.485+00:00','session.reading',1,NULL,'{"reading_id": 11, "kind": "point", "supersedes": null, "reading": {"config": 2, "nest": 1, "commanded_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "reported_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1083.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1233.4342306064098, 1930.1553461336957, -287.7891580747927], "position_world_mm": [332.79425776967855, -380.1891529381973, 204.73502502840057], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(28,'2026-11-22T17:41:50.490+00:00','session.progress',1,NULL,'{"done": 2, "skipped": 0, "planned": 3, "elapsed_s": 83.5, "remaining_s": 9.25, "doing": "measuring configuration 3"}');
INSERT INTO "events" VALUES(29,'2026-11-22T17:41:50.504+00:00','session.reading',1,NULL,'{"reading_id": 12, "kind": "point", "supersedes": null, "reading": {"config": 3, "nest": 1, "commanded_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "reported_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1092.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1212.9485277061294, 2233.424884231922, -35.26876839619594], "position_world_mm": [64.54916662792948, -526.2768402537183, 455.45714742332984], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(30,'2026-11-22T17:41:50.508+00:00','session.progress',1,NULL,'{"done": 3, "skipped": 0, "planned": 3, "elapsed_s": 92.5, "remaining_s": 0.0, "doing": "looking at the fixed nests"}');
INSERT INTO "events" VALUES(31,'2026-11-22T17:41:50.514+00:00','session.reading',1,NULL,'{"reading_id": 13, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1094.5, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(32,'2026-11-22T17:41:50.519+00:00','session.reading',1,NULL,'{"reading_id": 14, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1096.5, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(33,'2026-11-22T17:41:50.532+00:00','session.reading',1,NULL,'{"reading_id": 15, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1098.5, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(34,'2026-11-22T17:41:50.534+00:00','session.progress',1,NULL,'{"done": 3, "skipped": 0, "planned": 3, "elapsed_s": 98.5, "remaining_s": 0.0, "doing": "finished"}');
INSERT INTO "events" VALUES(35,'2026-11-22T17:41:50.538+00:00','session.state',1,NULL,'{"state": "finished", "reason": "Every configuration was measured or skipped.", "person": null}');
INSERT INTO "events" VALUES(36,'2026-11-22T17:41:50.547+00:00','session.state',2,NULL,'{"state": "planned", "reason": "The plan is stored; nothing has moved.", "person": null}');
INSERT INTO "events" VALUES(37,'2026-11-22T17:41:50.552+00:00','session.state',2,NULL,'{"state": "awaiting_confirmation", "reason": "The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?", "person": null}');
INSERT INTO "events" VALUES(38,'2026-11-22T17:41:50.554+00:00','session.progress',2,NULL,'{"done": 0, "skipped": 0, "planned": 2, "elapsed_s": 0.0, "remaining_s": null, "doing": "waiting for a person"}');
INSERT INTO "events" VALUES(39,'2026-11-22T17:41:50.559+00:00','session.state',2,NULL,'{"state": "running", "reason": "Eva had the session go on.", "person": "Eva"}');
INSERT INTO "events" VALUES(40,'2026-11-22T17:41:50.562+00:00','session.progress',2,NULL,'{"done": 0, "skipped": 0, "planned": 2, "elapsed_s": 0.0, "remaining_s": null, "doing": "making the instruments ready"}');
INSERT INTO "events" VALUES(41,'2026-11-22T17:41:50.565+00:00','session.identity',2,NULL,'{"device": "tracker", "finding": "first", "serial": "390001", "expected": "", "person": null}');
INSERT INTO "events" VALUES(42,'2026-11-22T17:41:50.567+00:00','session.note',2,NULL,'{"text": "The tracker is Leica AT401, serial 390001, firmware 3.8."}');
INSERT INTO "events" VALUES(43,'2026-11-22T17:41:50.570+00:00','session.identity',2,NULL,'{"device": "robot", "finding": "first", "serial": "120-1", "expected": "", "person": null}');
INSERT INTO "events" VALUES(44,'2026-11-22T17:41:50.573+00:00','session.note',2,NULL,'{"text": "The robot is ABB IRB 120, serial 120-1, firmware 6.08."}');
INSERT INTO "events" VALUES(45,'2026-11-22T17:41:50.575+00:00','session.note',2,NULL,'{"text": "The robot was told to move at 500 mm/s and 20 deg/s at most, and cannot be asked whether it keeps to that."}');
INSERT INTO "events" VALUES(46,'2026-11-22T17:41:50.578+00:00','session.progress',2,NULL,'{"done": 0, "skipped": 0, "planned": 2, "elapsed_s": 0.0, "remaining_s": null, "doing": "finding the tracker''s place in the world"}');
INSERT INTO "events" VALUES(47,'2026-11-22T17:41:50.654+00:00','session.reading',2,NULL,'{"reading_id": 16, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1052.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(48,'2026-11-22T17:41:50.665+00:00','session.reading',2,NULL,'{"reading_id": 17, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1053.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(49,'2026-11-22T17:41:50.669+00:00','session.reading',2,NULL,'{"reading_id": 18, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1055.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(50,'2026-11-22T17:41:50.672+00:00','session.reading',2,NULL,'{"reading_id": 19, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1056.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(51,'2026-11-22T17:41:50.680+00:00','session.reading',2,NULL,'{"reading_id": 20, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1058.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(52,'2026-11-22T17:41:50.684+00:00','session.reading',2,NULL,'{"reading_id": 21, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1059.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(53,'2026-11-22T17:41:50.692+00:00','session.registered',2,NULL,'{"rms_mm": 2.6254850544756925e-13, "two_face_mm": null}');
INSERT INTO "events" VALUES(54,'2026-11-22T17:41:50.694+00:00','session.note',2,NULL,'{"text": "The tracker''s scale agrees with the certified lengths: -0.0 ppm (u = 1.8 ppm)."}');
INSERT INTO "events" VALUES(55,'2026-11-22T17:41:50.697+00:00','session.progress',2,NULL,'{"done": 0, "skipped": 0, "planned": 2, "elapsed_s": 59.0, "remaining_s": null, "doing": "looking at the fixed nests"}');
INSERT INTO "events" VALUES(56,'2026-11-22T17:41:50.701+00:00','session.reading',2,NULL,'{"reading_id": 22, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1061.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(57,'2026-11-22T17:41:50.712+00:00','session.reading',2,NULL,'{"reading_id": 23, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1063.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(58,'2026-11-22T17:41:50.720+00:00','session.reading',2,NULL,'{"reading_id": 24, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1065.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(59,'2026-11-22T17:41:50.725+00:00','session.progress',2,NULL,'{"done": 0, "skipped": 0, "planned": 2, "elapsed_s": 65.0, "remaining_s": null, "doing": "measuring configuration 1"}');
INSERT INTO "events" VALUES(60,'2026-11-22T17:41:50.735+00:00','session.reading',2,NULL,'{"reading_id": 25, "kind": "point", "supersedes": null, "reading": {"config": 1, "nest": 1, "commanded_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "reported_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1074.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1378.7820983216018, 1466.1745914894477, -381.52523986964144], "position_world_mm": [694.5767607633579, -54.48320661771845, 114.07272073957677], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(61,'2026-11-22T17:41:50.738+00:00','session.progress',2,NULL,'{"done": 1, "skipped": 0, "planned": 2, "elapsed_s": 74.5, "remaining_s": 9.5, "doing": "measuring configuration 2"}');
INSERT INTO "events" VALUES(62,'2026-11-22T17:41:50.746+00:00','session.reading',2,NULL,'{"reading_id": 26, "kind": "point", "supersedes": null, "reading": {"config": 2, "nest": 1, "commanded_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "reported_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1083.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1233.4342306064098, 1930.1553461336957, -287.7891580747927], "position_world_mm": [332.79425776967855, -380.1891529381973, 204.73502502840057], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(63,'2026-11-22T17:41:50.757+00:00','session.progress',2,NULL,'{"done": 2, "skipped": 0, "planned": 2, "elapsed_s": 83.5, "remaining_s": 0.0, "doing": "looking at the fixed nests"}');
INSERT INTO "events" VALUES(64,'2026-11-22T17:41:50.764+00:00','session.reading',2,NULL,'{"reading_id": 27, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1085.5, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(65,'2026-11-22T17:41:50.774+00:00','session.reading',2,NULL,'{"reading_id": 28, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1087.5, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(66,'2026-11-22T17:41:50.778+00:00','session.reading',2,NULL,'{"reading_id": 29, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1089.5, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(67,'2026-11-22T17:41:50.787+00:00','session.progress',2,NULL,'{"done": 2, "skipped": 0, "planned": 2, "elapsed_s": 89.5, "remaining_s": 0.0, "doing": "finished"}');
INSERT INTO "events" VALUES(68,'2026-11-22T17:41:50.790+00:00','session.state',2,NULL,'{"state": "finished", "reason": "Every configuration was measured or skipped.", "person": null}');
INSERT INTO "events" VALUES(69,'2026-11-22T17:41:50.798+00:00','session.state',3,NULL,'{"state": "planned", "reason": "The plan is stored; nothing has moved.", "person": null}');
INSERT INTO "events" VALUES(70,'2026-11-22T17:41:50.805+00:00','session.state',3,NULL,'{"state": "awaiting_confirmation", "reason": "The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?", "person": null}');
INSERT INTO "events" VALUES(71,'2026-11-22T17:41:50.807+00:00','session.progress',3,NULL,'{"done": 0, "skipped": 0, "planned": 5, "elapsed_s": 0.0, "remaining_s": null, "doing": "waiting for a person"}');
INSERT INTO "events" VALUES(72,'2026-11-22T17:41:50.812+00:00','session.state',3,NULL,'{"state": "running", "reason": "Eva had the session go on.", "person": "Eva"}');
INSERT INTO "events" VALUES(73,'2026-11-22T17:41:50.815+00:00','session.progress',3,NULL,'{"done": 0, "skipped": 0, "planned": 5, "elapsed_s": 0.0, "remaining_s": null, "doing": "making the instruments ready"}');
INSERT INTO "events" VALUES(74,'2026-11-22T17:41:50.819+00:00','session.identity',3,NULL,'{"device": "tracker", "finding": "first", "serial": "390001", "expected": "", "person": null}');
INSERT INTO "events" VALUES(75,'2026-11-22T17:41:50.824+00:00','session.note',3,NULL,'{"text": "The tracker is Leica AT401, serial 390001, firmware 3.8."}');
INSERT INTO "events" VALUES(76,'2026-11-22T17:41:50.827+00:00','session.identity',3,NULL,'{"device": "robot", "finding": "first", "serial": "120-1", "expected": "", "person": null}');
INSERT INTO "events" VALUES(77,'2026-11-22T17:41:50.832+00:00','session.note',3,NULL,'{"text": "The robot is ABB IRB 120, serial 120-1, firmware 6.08."}');
INSERT INTO "events" VALUES(78,'2026-11-22T17:41:50.836+00:00','session.note',3,NULL,'{"text": "The robot was told to move at 500 mm/s and 20 deg/s at most, and cannot be asked whether it keeps to that."}');
INSERT INTO "events" VALUES(79,'2026-11-22T17:41:50.840+00:00','session.progress',3,NULL,'{"done": 0, "skipped": 0, "planned": 5, "elapsed_s": 0.0, "remaining_s": null, "doing": "finding the tracker''s place in the world"}');
INSERT INTO "events" VALUES(80,'2026-11-22T17:41:50.904+00:00','session.reading',3,NULL,'{"reading_id": 30, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1052.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(81,'2026-11-22T17:41:50.909+00:00','session.reading',3,NULL,'{"reading_id": 31, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1053.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(82,'2026-11-22T17:41:50.921+00:00','session.reading',3,NULL,'{"reading_id": 32, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1055.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(83,'2026-11-22T17:41:50.924+00:00','session.reading',3,NULL,'{"reading_id": 33, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1056.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(84,'2026-11-22T17:41:50.933+00:00','session.reading',3,NULL,'{"reading_id": 34, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1058.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(85,'2026-11-22T17:41:50.940+00:00','session.reading',3,NULL,'{"reading_id": 35, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1059.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(86,'2026-11-22T17:41:50.944+00:00','session.registered',3,NULL,'{"rms_mm": 2.6254850544756925e-13, "two_face_mm": null}');
INSERT INTO "events" VALUES(87,'2026-11-22T17:41:50.947+00:00','session.note',3,NULL,'{"text": "The tracker''s scale agrees with the certified lengths: -0.0 ppm (u = 1.8 ppm)."}');
INSERT INTO "events" VALUES(88,'2026-11-22T17:41:50.952+00:00','session.progress',3,NULL,'{"done": 0, "skipped": 0, "planned": 5, "elapsed_s": 59.0, "remaining_s": null, "doing": "looking at the fixed nests"}');
INSERT INTO "events" VALUES(89,'2026-11-22T17:41:50.961+00:00','session.reading',3,NULL,'{"reading_id": 36, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1061.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(90,'2026-11-22T17:41:50.964+00:00','session.reading',3,NULL,'{"reading_id": 37, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1063.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(91,'2026-11-22T17:41:50.966+00:00','session.reading',3,NULL,'{"reading_id": 38, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1065.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(92,'2026-11-22T17:41:50.967+00:00','session.progress',3,NULL,'{"done": 0, "skipped": 0, "planned": 5, "elapsed_s": 65.0, "remaining_s": null, "doing": "measuring configuration 1"}');
INSERT INTO "events" VALUES(93,'2026-11-22T17:41:50.970+00:00','session.reading',3,NULL,'{"reading_id": 39, "kind": "point", "supersedes": null, "reading": {"config": 1, "nest": 1, "commanded_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "reported_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1074.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1378.7820983216018, 1466.1745914894477, -381.52523986964144], "position_world_mm": [694.5767607633579, -54.48320661771845, 114.07272073957677], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(94,'2026-11-22T17:41:50.973+00:00','session.progress',3,NULL,'{"done": 1, "skipped": 0, "planned": 5, "elapsed_s": 74.5, "remaining_s": 38.0, "doing": "measuring configuration 2"}');
INSERT INTO "events" VALUES(95,'2026-11-22T17:41:50.980+00:00','session.stop_skipped',3,NULL,'{"config": 2, "time_s": 1081.5, "reason": "no reflector near nest 1"}');
INSERT INTO "events" VALUES(96,'2026-11-22T17:41:50.983+00:00','session.progress',3,NULL,'{"done": 1, "skipped": 1, "planned": 5, "elapsed_s": 81.5, "remaining_s": 24.75, "doing": "measuring configuration 3"}');
INSERT INTO "events" VALUES(97,'2026-11-22T17:41:50.993+00:00','session.reading',3,NULL,'{"reading_id": 40, "kind": "point", "supersedes": null, "reading": {"config": 3, "nest": 1, "commanded_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "reported_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1090.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1212.9485277061294, 2233.424884231922, -35.26876839619594], "position_world_mm": [64.54916662792948, -526.2768402537183, 455.45714742332984], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(98,'2026-11-22T17:41:50.994+00:00','session.progress',3,NULL,'{"done": 2, "skipped": 1, "planned": 5, "elapsed_s": 90.5, "remaining_s": 17.0, "doing": "looking at the fixed nests"}');
INSERT INTO "events" VALUES(99,'2026-11-22T17:41:50.996+00:00','session.reading',3,NULL,'{"reading_id": 41, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1092.5, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(100,'2026-11-22T17:41:50.999+00:00','session.reading',3,NULL,'{"reading_id": 42, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1094.5, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(101,'2026-11-22T17:41:51.012+00:00','session.reading',3,NULL,'{"reading_id": 43, "kind": "fixed_nest", "supersedes": null, "reading": {"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1096.5, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}}');
INSERT INTO "events" VALUES(102,'2026-11-22T17:41:51.013+00:00','session.progress',3,NULL,'{"done": 2, "skipped": 1, "planned": 5, "elapsed_s": 96.5, "remaining_s": 21.0, "doing": "measuring configuration 4"}');
INSERT INTO "events" VALUES(103,'2026-11-22T17:41:51.017+00:00','session.stops_added',3,NULL,'{"person": "Ada", "stops": [{"config": 11, "joints_rad": [-1.166881122304629, 0.7842638323709402, -0.03150691943289363, -2.4677785814246995, -1.1060728262120585, 2.690529207836934], "nest": 1, "repeat_of": null}], "diagnosis_id": null}');
INSERT INTO "events" VALUES(104,'2026-11-22T17:41:51.019+00:00','session.state',4,NULL,'{"state": "planned", "reason": "The plan is stored; nothing has moved.", "person": null}');
INSERT INTO "events" VALUES(105,'2026-11-22T17:41:51.022+00:00','session.entry',4,NULL,'{"entry": 1, "step_id": "", "kind": "control", "text": "running: Eva started the session."}');
INSERT INTO "events" VALUES(106,'2026-11-22T17:41:51.022+00:00','session.state',4,NULL,'{"state": "running", "reason": "Eva started the session.", "person": "Eva"}');
INSERT INTO "events" VALUES(107,'2026-11-22T17:41:51.040+00:00','session.entry',4,NULL,'{"entry": 2, "step_id": "", "kind": "control", "text": "The ballbar answers with serial number L20042."}');
INSERT INTO "events" VALUES(108,'2026-11-22T17:41:51.044+00:00','session.entry',4,NULL,'{"entry": 3, "step_id": "tool/initialise", "kind": "shown", "text": ""}');
INSERT INTO "events" VALUES(109,'2026-11-22T17:41:51.047+00:00','session.entry',4,NULL,'{"entry": 4, "step_id": "tool/initialise", "kind": "measured", "text": ""}');
INSERT INTO "events" VALUES(110,'2026-11-22T17:41:51.052+00:00','session.entry',4,NULL,'{"entry": 5, "step_id": "", "kind": "control", "text": "zero_lost"}');
INSERT INTO "events" VALUES(111,'2026-11-22T17:41:51.056+00:00','session.entry',4,NULL,'{"entry": 6, "step_id": "", "kind": "control", "text": "hand_over"}');
INSERT INTO "events" VALUES(112,'2026-11-22T17:41:51.060+00:00','session.entry',4,NULL,'{"entry": 7, "step_id": "", "kind": "control", "text": "paused: Lunch: an hour."}');
INSERT INTO "events" VALUES(113,'2026-11-22T17:41:51.060+00:00','session.state',4,NULL,'{"state": "paused", "reason": "Lunch: an hour.", "person": "Ada"}');
INSERT INTO "events" VALUES(114,'2026-11-22T17:41:51.064+00:00','session.state',5,NULL,'{"state": "planned", "reason": "The plan is stored; nothing has moved.", "person": null}');
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
INSERT INTO "links" VALUES(1,1,'sessions',1,X'51875ABAA708D632A9C00FCF85943B3C1D5CCF4EF4C037C9C70A95AFB1140097');
INSERT INTO "links" VALUES(2,1,'session_states',1,X'496011DCC080374BBD109AC9E4760CF6288BCF298F479988507B17CFEEB54178');
INSERT INTO "links" VALUES(3,1,'events',1,X'86895DBFF9C22AE887E827AAB2AFB2A1DFD4C8CB84B82327AB8AC787854D3365');
INSERT INTO "links" VALUES(4,1,'session_states',2,X'DF72A23C0104BB12C5C423A8913624BC8D81BC652F0ABB6877D2EC81514A93D0');
INSERT INTO "links" VALUES(5,1,'events',2,X'0AD02E1E734A6D511F1114909E308A2E2C65BC09601013F08D5AF0A0350D1FEF');
INSERT INTO "links" VALUES(6,1,'events',3,X'6B9FDD2CEE84A06C58B95190E0C49E8D08BDC8D988A964104DFBC7824F26722F');
INSERT INTO "links" VALUES(7,1,'session_states',3,X'C3FBF1DAF77B4949547782510795EC7A79CBEDEDE3FBB7BEA2EADCB4046B2DCC');
INSERT INTO "links" VALUES(8,1,'events',4,X'FE83A0FADDB6366531E7C25245E32A881BD570345873D1851236A9CCAEE6452B');
INSERT INTO "links" VALUES(9,1,'events',5,X'32D2C1862E98C6E3894DA62755F2EABCB45D2B2AF89F411E330818C473CA2B2B');
INSERT INTO "links" VALUES(10,1,'events',6,X'9EFB0282061455785468D85F9FFB670961CA6E57174717358F0355F1D79FC8B0');
INSERT INTO "links" VALUES(11,1,'notes',1,X'ED5BAB78B7A2909BCDABE3413369ECFDB30A583F2DADD910E08A5FE2E6B522A4');
INSERT INTO "links" VALUES(12,1,'events',7,X'CFD372E606A32EAE5E0F5DB95650DA0651CE5D35AC7AAD1E1AFE2D929CA3B85F');
INSERT INTO "links" VALUES(13,1,'events',8,X'DB92AC6F710849BD81A92BE365D115814593E5438916F80F2A9E26A5F90AA032');
INSERT INTO "links" VALUES(14,1,'notes',2,X'81A92E3B1FE114DD3C14A6508784B636037B21E4E04FC76F06E4AE6F01350303');
INSERT INTO "links" VALUES(15,1,'events',9,X'8950455BF4AC1D053D1C670EBD07581B17CDB62EC16B3512E2B0E74CAFC29DA3');
INSERT INTO "links" VALUES(16,1,'notes',3,X'ED136E8878D529889CC3CC56B659A7D1C65D6FD6CB04F4914AEB27DAA3D2C81A');
INSERT INTO "links" VALUES(17,1,'events',10,X'53FE5781A59E9D6A71CE8EC2401D7BC8D5843D3AA3EC9887D8F02683F6B9F9FA');
INSERT INTO "links" VALUES(18,1,'events',11,X'E6D7609E2C00C3B121A513EE5CDE92EB34316397921E1095C77F3D1CD27152E4');
INSERT INTO "links" VALUES(19,1,'readings',1,X'94C9F703AB1FDEEB1E884887BD143DF31F1FBB3322BAE5E8C0FD7B6982A5E8F2');
INSERT INTO "links" VALUES(20,1,'events',12,X'4DE0669C1116EF3105EB5EFE7772DBC12E43D07E18ADD6BF8CFC34E58809112D');
INSERT INTO "links" VALUES(21,1,'readings',2,X'ED3C5DA157CE8CBC74DC76D9B6D5008C0E4CEB7A8E5E148CED64D9725F94C5B9');
INSERT INTO "links" VALUES(22,1,'events',13,X'9DC9F39122AF4A6C45B2EF8D534BEA63B66C7C909A53B267E74E1612D161810F');
INSERT INTO "links" VALUES(23,1,'readings',3,X'3FF1E33D964589077B7E60D428C9C0F3BB7A2B42CF347F3CDF37425133239F36');
INSERT INTO "links" VALUES(24,1,'events',14,X'FBA607238C0FEA3F2CC43BCC40B6E2250869BF3844CEBE55907F84174B691424');
INSERT INTO "links" VALUES(25,1,'readings',4,X'FFFD77794C79558C0839C164C6E981EAFC1CEB5F2A722EED844573A77C89CF19');
INSERT INTO "links" VALUES(26,1,'events',15,X'CAE79EED2B7DC967CB908E87798E7E22D31290CA93270F5369310051823EB594');
INSERT INTO "links" VALUES(27,1,'readings',5,X'057F32E421A537C02759A17F4357BF5FB5BE0A04650F28371418885310066277');
INSERT INTO "links" VALUES(28,1,'events',16,X'B50F686A5CFE36BD9185C0139D6D85D54A7B9980F83FAA3C2B7D5E770D3CB8EC');
INSERT INTO "links" VALUES(29,1,'readings',6,X'C6BE287481791EC319ECB9C72C4AFE436E97B41AED376C27A65A6A7468A8A403');
INSERT INTO "links" VALUES(30,1,'events',17,X'EDABF7569E185794C335C32238C095774BDE860EBD948619FF8031A24B3B6E59');
INSERT INTO "links" VALUES(31,1,'registrations',1,X'739EF279392E13577F739B3C559B7753A81390F37D8A7ACD13AD973F00F244F6');
INSERT INTO "links" VALUES(32,1,'events',18,X'6C0DD0FC7E78DA96F836718BC17EC719E0EA6CB4A97646EA2921DA5C730A8D42');
INSERT INTO "links" VALUES(33,1,'notes',4,X'5BEE6111D0FF9D500CE1079E62D10365BA08BC82E1E7F4005178772E9FDEC538');
INSERT INTO "links" VALUES(34,1,'events',19,X'0739F41E8F0D34F9C9C844515D83C5330F6AF2AC90126C853E39C83A47ABA37C');
INSERT INTO "links" VALUES(35,1,'events',20,X'1EC0F1EBD1E83052B1193998AF359CBB8BD9493B32C8E6507EDD47827B3EB174');
INSERT INTO "links" VALUES(36,1,'readings',7,X'FDB40C708239ACEFD315B0D9331269235CB31C87727F7CC726E36A80D1EDAEC3');
INSERT INTO "links" VALUES(37,1,'events',21,X'BABEE24F271589221219F113A741788C37545BB675B7B708574BFFBDBD9308B8');
INSERT INTO "links" VALUES(38,1,'readings',8,X'A328147EF96AA25F1E7C5B89371BF526B7F99566FA54F7F2A62873B8DB05EA72');
INSERT INTO "links" VALUES(39,1,'events',22,X'8D2DE27F283C90B879001B52121952B7817A2CE2C3B7A6462E79233CD11B047D');
INSERT INTO "links" VALUES(40,1,'readings',9,X'3E4CF3175C9A58E2723850FC9028B98612E58206A7227B6CBE6B9F281BCB9172');
INSERT INTO "links" VALUES(41,1,'events',23,X'2DD4C4C4A26F68296D6D81A9B9E9F111D322DE10C6E1B35404698945D1D34528');
INSERT INTO "links" VALUES(42,1,'events',24,X'F9837282505D124E1FE79FC75569049DBBC39A783C27316B7F409BFA1F0CBE43');
INSERT INTO "links" VALUES(43,1,'readings',10,X'742453A91E79490E6405EE8F6971340C4C10C7FE2E9A7E5EDCFD3423760B3C73');
INSERT INTO "links" VALUES(44,1,'events',25,X'26DDB78A1113FEB08ABB534DFE05D2668A091CBC53980FE6F2E1EECD94164FC4');
INSERT INTO "links" VALUES(45,1,'events',26,X'5036AF3383C223F5605DCF2DABC5AC6793C8E287E0A67D4AC7DB6A3E19A2A481');
INSERT INTO "links" VALUES(46,1,'readings',11,X'42E3129E8153A3097CD1AA361EDBCF410A1105948689107DDF1EAB1AF796A75D');
INSERT INTO "links" VALUES(47,1,'events',27,X'38D6F12BB925DE9E328EA4725611C0541A991387ECEEA16F54A4366AD50CEB8C');
INSERT INTO "links" VALUES(48,1,'events',28,X'FDAB47FEBD9988A154C096756A2EFEB39EA975E76F30C458A85237EAF857E2A4');
INSERT INTO "links" VALUES(49,1,'readings',12,X'5FE7A5A52C97CB2E3113BB3F24A756A7B4D19B162B479800133A127C8D1F9E7E');
INSERT INTO "links" VALUES(50,1,'events',29,X'980219F281077B10D010A0B2710CDB071862B70C118647010D8829BDF9FE2706');
INSERT INTO "links" VALUES(51,1,'events',30,X'FD78D147D7BA943810109459BDE7B0BA6C8704F135A2DF9C77E59F232A9BA6FE');
INSERT INTO "links" VALUES(52,1,'readings',13,X'946C39759A8FB797007AAE0E09323EC7B463D9DBF9717EC3631FC14429183288');
INSERT INTO "links" VALUES(53,1,'events',31,X'1156130FB5B20CFB09DB0E86B928AF6E3B3DCF43531F689543DBCB44B9350A1D');
INSERT INTO "links" VALUES(54,1,'readings',14,X'68DD4DC8ED7B7291436DF9069817E14CF37B631959B027A4035904E8B588674F');
INSERT INTO "links" VALUES(55,1,'events',32,X'B7954F23F187BED9A6BFE274F7838F727C189C2E4745B2892C4200BFBD7D942E');
INSERT INTO "links" VALUES(56,1,'readings',15,X'0BDA9B047610119CEE2A628E5F278F11CACB5201256B5C5F1F5C26BDF3C32100');
INSERT INTO "links" VALUES(57,1,'events',33,X'82457F4068DBBAFD2DE954B3AFB548E2B6C86C1F78DC8264DEFB69396C2B1551');
INSERT INTO "links" VALUES(58,1,'events',34,X'8E0527F9AF1FB47ED675DF808F1F829D4F60A81E7568E769080962A4F7C804CF');
INSERT INTO "links" VALUES(59,1,'session_states',4,X'7CABA7B4DEAA74E209599BCC5FF99A53D3B82B3228FB07BB45B98447B6AA1A5B');
INSERT INTO "links" VALUES(60,1,'events',35,X'51D050F0D6AD4A671E1694E6BE4E1495A89532FCE5CE004BC495FCF55595149E');
INSERT INTO "links" VALUES(61,2,'sessions',2,X'395051C80F2312C5E476801098B844BF9EC63118B002A0DE61CC37FC2E96DEF8');
INSERT INTO "links" VALUES(62,2,'session_states',5,X'66258C393E6AAC1829DFF14B28FD642DDD44A24C62FD6187206AA6377BA2F3B3');
INSERT INTO "links" VALUES(63,2,'events',36,X'D21870B25D98AC8EFACE75FBDE5E9CBDAD4B968D365C52A434E7F538552E72FA');
INSERT INTO "links" VALUES(64,2,'session_states',6,X'F5C1B24059071287F0B7C87D1FE3CD61F330C3FE20A09D23FDD9B6DE788A0F28');
INSERT INTO "links" VALUES(65,2,'events',37,X'35AA41AE8971BFBDDE1F3CAED47F41D91CEF26FD922EB5D1F19F22E5423467DC');
INSERT INTO "links" VALUES(66,2,'events',38,X'242DA19A6AE6A373D77983A2B69A3FB444EE758D8C89A2CCD50DF16DD711AE09');
INSERT INTO "links" VALUES(67,2,'session_states',7,X'08ACD721C99ECE16747574134A483D708D4E1EEDBDCC168174C074F635CE86D6');
INSERT INTO "links" VALUES(68,2,'events',39,X'BD6F7A44ED2F6BBC34453588D6DAD3CA27685BB51D72B0B6BAA32F7BF52FA32B');
INSERT INTO "links" VALUES(69,2,'events',40,X'AB901A35C9C00B8DD4B20FBD128758FD6D598AB7C4F08D031DF087F4362474A0');
INSERT INTO "links" VALUES(70,2,'events',41,X'0C62A6397C4E7C4DFC215723C722D5A149C480351EA7C511C13F3689E5644646');
INSERT INTO "links" VALUES(71,2,'notes',5,X'47091599861F43C6369B43E892CE62E516DAFBA9BEA71D82DF273BDD3DA6313F');
INSERT INTO "links" VALUES(72,2,'events',42,X'C5F6171E443C571FBD42C34C398B0DF5F8E8432EB48BCAA9171A5793616C6214');
INSERT INTO "links" VALUES(73,2,'events',43,X'910BFA8CF8FA08F98E109C02130DAE206D71B1ECE976CF49DFF08EDC4BD97107');
INSERT INTO "links" VALUES(74,2,'notes',6,X'649F2DD3D6A5C67A154CA6881DE5D08C5B047D5ADF57143AEEC76302F20B7DAA');
INSERT INTO "links" VALUES(75,2,'events',44,X'86CF1945220BD7322C58229488B0F1A856FFA341FBB5B7C09A330004B29BFC14');
INSERT INTO "links" VALUES(76,2,'notes',7,X'584064E4307ADFE72CF26F50908560A6E14D8ABCE06F4112BCF3FD35E58448F2');
INSERT INTO "links" VALUES(77,2,'events',45,X'2E95B21A95C81557C4B17D880211268B3C50A93BE58C1C615B87C93113C4A6FB');
INSERT INTO "links" VALUES(78,2,'events',46,X'C0E83844B9683898E9E9F813E3C505D5A2A962C6D5623D24248BB3BD70CCF6BA');
INSERT INTO "links" VALUES(79,2,'readings',16,X'E0F4C1B3D974946825D452AA4304F3FEDFAC714180F0953087215BDC17724861');
INSERT INTO "links" VALUES(80,2,'events',47,X'03142CEE962D8927AC5F82731E3367682C9FDFCB5A194F2DEB58BAD40CE3E30D');
INSERT INTO "links" VALUES(81,2,'readings',17,X'1805400E68B014CEABAA65C2EDEC25EF98E5D777FDC75F799874A2C2F2F00594');
INSERT INTO "links" VALUES(82,2,'events',48,X'B9D09A24B7DC1A452CA7F5DE08B8D349BE079109064FF2F9A25176938B8D6B34');
INSERT INTO "links" VALUES(83,2,'readings',18,X'623D0037C9B014F6C6AF4ED8EFD8B9D93A308297FFAF46F2A008F3DF3F3FE83D');
INSERT INTO "links" VALUES(84,2,'events',49,X'580954A25E255F55DC8540F681989062EBFD8C03675B278BFB8F90994A85645C');
INSERT INTO "links" VALUES(85,2,'readings',19,X'C8760E7D4CC2B5B327B9EE059FBA251DE3450B255DF1A7EF52862F8562DFC58E');
INSERT INTO "links" VALUES(86,2,'events',50,X'9054EA8D0010216A58A95ACB23A8BA7BEC34656F03F91FD24BFC734A83AB228E');
INSERT INTO "links" VALUES(87,2,'readings',20,X'1D9C848997E75E28D345B33B4CE50170B7346165B5953A93E36ED34FE2C7CC7E');
INSERT INTO "links" VALUES(88,2,'events',51,X'1A7DEEBDBFFBD5B4B6EB2D23CD46C131B265F398CC35F7241ED27F7E5D3060A0');
INSERT INTO "links" VALUES(89,2,'readings',21,X'3D053D589E595126B0DC241661775E79D6BF261AFEEE505F82D9BA22DCFC03E7');
INSERT INTO "links" VALUES(90,2,'events',52,X'85FA27E87F5752180E6CF04F2F22F634CB03922F82B31B3AD774016A69BA7999');
INSERT INTO "links" VALUES(91,2,'registrations',2,X'70A1FE20AC7D425850F5431DD8756315BE4D4DEFB142498DF677136C64FE4184');
INSERT INTO "links" VALUES(92,2,'events',53,X'597121CB64C0EFBBA31CC345BEF99299E8077A3D245CD50E0558104A7109DEC5');
INSERT INTO "links" VALUES(93,2,'notes',8,X'E81C31C4DEBD926B13B95939E76F87A9CA2A8C4DBF43DEEA028207892F71B637');
INSERT INTO "links" VALUES(94,2,'events',54,X'14C6CFC2C2DC846C28C366CD425397FCA91BE89CBD1811EC004C66F0FD3C57DB');
INSERT INTO "links" VALUES(95,2,'events',55,X'EBBE68B068C7DA2665F59D16C62A3B92CD268AD8797E33CFDE889D5C69B09A2E');
INSERT INTO "links" VALUES(96,2,'readings',22,X'C9E66D01334B4A8899307247BED37F779686A4F04B0A679B0A7530B6EFCC755D');
INSERT INTO "links" VALUES(97,2,'events',56,X'C9722F33856FBB6C9305E063CFC99AF5EA452ACB16FD3F84BE17B81E4209CCF8');
INSERT INTO "links" VALUES(98,2,'readings',23,X'46D985C239574C91E63B0DF6E4D62FEB0E1F8A614ED253598A99DC4C2BF0098E');
INSERT INTO "links" VALUES(99,2,'events',57,X'43BF00F090C1D0DBA40FBB4C70684718F3564BDE4F5E7BE3B81CED54824372CE');
INSERT INTO "links" VALUES(100,2,'readings',24,X'C64C3C3EFF9C97EB902574F1ACA245B9A19361BBC968DDED35B530C23907F745');
INSERT INTO "links" VALUES(101,2,'events',58,X'20CC1F07002CB34127E6C31821321E43CEB209F001591244355EB73854753CE7');
INSERT INTO "links" VALUES(102,2,'events',59,X'8DD3C538A23DCC358ACEBBBCF300E9E8ABE92D2C5E3887FE9A22387E668586CC');
INSERT INTO "links" VALUES(103,2,'readings',25,X'ED3B174E4A45EAA81B4B20A858CDD2464E43DF9F7F3B1E2B6A8FA475AA624B9B');
INSERT INTO "links" VALUES(104,2,'events',60,X'8148AB690C3116DAD4D69AAF15E9DDEC5B7D90AE18F5B8D9A51FF3B28C9A4A27');
INSERT INTO "links" VALUES(105,2,'events',61,X'5EFB6687247D8E3BF2B98C83B0872EED71017B8E7E76BB0C8BE970751610127E');
INSERT INTO "links" VALUES(106,2,'readings',26,X'EA8CB0F79303824C939D451368E1842B4FB70CB364864B51F7C947403D55F9AF');
INSERT INTO "links" VALUES(107,2,'events',62,X'B05586698ED24AB2F857AB3E9A8FC5F1E077F94F9BCBA21DA1D961041F3EA5FE');
INSERT INTO "links" VALUES(108,2,'events',63,X'166058B204B59772F1E411E4D6A225FBFF9F3BD2A5736CB81D0083CCFDFC369E');
INSERT INTO "links" VALUES(109,2,'readings',27,X'5D4CCE63BA064EC8AD37D12A18B98A83A1BA92C0AFC2F120704246BB24891A52');
INSERT INTO "links" VALUES(110,2,'events',64,X'5343EAAFC94570F0495BCE262971716ED36E701A7547D454BED447339C9BD7A1');
INSERT INTO "links" VALUES(111,2,'readings',28,X'1124C8E2C983571CE1ED498066087356DFFC1DEFC4E381C58CEAF749A69251BF');
INSERT INTO "links" VALUES(112,2,'events',65,X'2156EC6CB1501F26F88550DCD847570760A1C0018F8DB6FD54B340ED9A68386D');
INSERT INTO "links" VALUES(113,2,'readings',29,X'519ECFEE00103856E210593333E0DEB8DC747D299C9767E246456148531B99E6');
INSERT INTO "links" VALUES(114,2,'events',66,X'78903936622C2529481E7F83A57B7E988EEFE181A45A6699F397A24596F40C7D');
INSERT INTO "links" VALUES(115,2,'events',67,X'55B4B2DB6CFAE2D6A088ABD9899E6C6CDEB018DA8B082875A0A3E29B4B784827');
INSERT INTO "links" VALUES(116,2,'session_states',8,X'EBD8813F53F86EBE72F6669E01DF77885FD42BDB68C904A6CBFADFB9B6B069B4');
INSERT INTO "links" VALUES(117,2,'events',68,X'9F71773FA6820C430DED990603AA157461646F62EAB76D50FD0467887CA2A389');
INSERT INTO "links" VALUES(118,3,'sessions',3,X'A9CE0C378EFBCB6D0D25DB5DCF9F5F4D0D3299FEDD7528D021ECD7F31BCD36C2');
INSERT INTO "links" VALUES(119,3,'session_states',9,X'996DC484FD2DDBFE3954758D7DC7EA2C73165A4E15E1B5154FC84AB32B636915');
INSERT INTO "links" VALUES(120,3,'events',69,X'C2C14222FF3A503ED3456C81A181F8F1377CD24298B8CEB47F2949BA72D9055C');
INSERT INTO "links" VALUES(121,3,'session_states',10,X'A99DDE919A5A123BDF1EC9298D8857AA192BCDEC9654CCD4941DCA373DA9B15A');
INSERT INTO "links" VALUES(122,3,'events',70,X'9851C1DB7B9F7934CA208F225F1A32DCFC01B50599B9890248ADD435CF090E18');
INSERT INTO "links" VALUES(123,3,'events',71,X'0CCAF1CA8F2D9CF622274F3175D99BF937562DD1B44E902D368774A95EB7496F');
INSERT INTO "links" VALUES(124,3,'session_states',11,X'27525EED6E70802B4FBE490271E743ADB85EB52245B5CBA895B7648FD3C85FFC');
INSERT INTO "links" VALUES(125,3,'events',72,X'485808F37F16AAC505B49252C90F0A0537D5CFFEB9D5BDED92AF3C76A4BC05C6');
INSERT INTO "links" VALUES(126,3,'events',73,X'638AD34E7EC14F0C9AC7545D015B54E82748EB36DAFE681FF31A4A708FC0A3F8');
INSERT INTO "links" VALUES(127,3,'events',74,X'1C475830870809178CF7810E236DA0FCE9A8BB77BFCB549A4EE6FA434E2C6F03');
INSERT INTO "links" VALUES(128,3,'notes',9,X'5DB6FC062C51F4FD89928BF100CB94158EDBC1BEB3D0B5B3B24C8A04E6D7D920');
INSERT INTO "links" VALUES(129,3,'events',75,X'76CE0401BBF7C59B4F42A03806DFD1EC29774603E5DA51A855DF566DA362DE33');
INSERT INTO "links" VALUES(130,3,'events',76,X'E5B166416BDB90A0798599E1CDD3D9E65A573936733FDB7FBB83E9CBE3187F8E');
INSERT INTO "links" VALUES(131,3,'notes',10,X'E48376124AFA348420B462A9D68C5C5B5C51F4467CC4CCD3584832C07B63A37C');
INSERT INTO "links" VALUES(132,3,'events',77,X'3CA7D00130F036A59D3F6272D937BF419AD2F08D5396E8328A5B8AE80137BDAA');
INSERT INTO "links" VALUES(133,3,'notes',11,X'2111EFBEB6C2FC7788DD226B0A0D08A1B1E50243714D90115CA4893985DA8D91');
INSERT INTO "links" VALUES(134,3,'events',78,X'FD18BFB7E6FDF424298B6E4F9DDB0FA399D24F81CE1FBA73E47D1EB9B63B070E');
INSERT INTO "links" VALUES(135,3,'events',79,X'0946F6AF7BF6ACE188952A2267D28ED50018DF0C9D8288771F1B5F827F841687');
INSERT INTO "links" VALUES(136,3,'readings',30,X'4442875A5F70C489D8C4C8C600F8C0F07203372ACE23BC39FE9B9C62B68EC773');
INSERT INTO "links" VALUES(137,3,'events',80,X'CAF553A293BF8746AF670C1B449C9CD9549303E0DB401EC48DB9179639D760F5');
INSERT INTO "links" VALUES(138,3,'readings',31,X'399BDEE3D3E1F4A10404B76974D0C068F7BEC2264E1FC4262BC963221F630F87');
INSERT INTO "links" VALUES(139,3,'events',81,X'E73EE2F051E13E19435CC4E63CE49C250C3A870B5644D1AE522CFBC6727EF8A1');
INSERT INTO "links" VALUES(140,3,'readings',32,X'C55920E028CE7785721C8D2E90959594F5A0B4C0BFE6136D69EF8086338E3485');
INSERT INTO "links" VALUES(141,3,'events',82,X'CC2FFEC64E32639A695B5DF40BB60F16A2CBA6178F45C016430811B984CAFE9B');
INSERT INTO "links" VALUES(142,3,'readings',33,X'28E20367095D3A318A435F7E3AA2AB83C9E570CE4190B737D7D0FAF4AF2A91B5');
INSERT INTO "links" VALUES(143,3,'events',83,X'A34C9542F507098DAF14C48D7AD6632BD84F504BBC07E5E16590DA8ACC9D1BB8');
INSERT INTO "links" VALUES(144,3,'readings',34,X'6C89D57B629A8076A4493F83F5FC71F0BCC02B29209F094B7281B54B3D5C70D9');
INSERT INTO "links" VALUES(145,3,'events',84,X'E2117E35F992A9F04D933AE834265D3110F01E89C0D348D7F0FCE2CB31C33D92');
INSERT INTO "links" VALUES(146,3,'readings',35,X'19F6F6D2EBA50860E7B453F1B7A060B2114E904973DA83BD788C7CE78EAF29CB');
INSERT INTO "links" VALUES(147,3,'events',85,X'69C78520246AB48429E024F40FD3F1B31831A535ED1EDE6633ABE01355163FBC');
INSERT INTO "links" VALUES(148,3,'registrations',3,X'CA10F7B78BAED3124F392F3F0A5A732ACC4C8879AF870F1D4FF4B906A658383C');
INSERT INTO "links" VALUES(149,3,'events',86,X'4E4AEFC10947B3F4B8015221758BD916863B563D5709B3EEB3EFA66D718CD76B');
INSERT INTO "links" VALUES(150,3,'notes',12,X'8440BCB2D9FE145CEAFF5025A6A3239B9FAD43CA2F64D8430A8F91D9F550A618');
INSERT INTO "links" VALUES(151,3,'events',87,X'E5A3371C3D5EC88AF4BCCB5765F290CA8458467697372154C6DC37DD0CAB95DB');
INSERT INTO "links" VALUES(152,3,'events',88,X'9CA64268A7BA11F865567332D53AD978E0715D4A136A0FF49FAEB1FF6A623CC9');
INSERT INTO "links" VALUES(153,3,'readings',36,X'4E9413838BBE06223F7A3BE8B835CE9A31C2D46FBA310EC93BBDCDA052856D3E');
INSERT INTO "links" VALUES(154,3,'events',89,X'E4DA8C55011BCD0057029B0746E3BCD585985C55931F0F9FA1E71F1968E24BFB');
INSERT INTO "links" VALUES(155,3,'readings',37,X'390C9E8D11CB98FB024F2C31283CD3D6A6F0475CB2C1CF67120BBC6E76C31A5D');
INSERT INTO "links" VALUES(156,3,'events',90,X'C58B6F2DAEC0515DF5F7CBEFBFEDA2FB946C296D6C4E988D172BD0965DF3B1F2');
INSERT INTO "links" VALUES(157,3,'readings',38,X'FA816AF1701460CA5AD124F973672E970BDE045B856A49FD89D78E13CCABCA20');
INSERT INTO "links" VALUES(158,3,'events',91,X'AFA94E93C43BBE3909DE195DA822324E025CAD9013E2C50D874E084EFCB8AFAD');
INSERT INTO "links" VALUES(159,3,'events',92,X'4A8DB75725936352F32A697829D992A01B06852451AC48C568652717C08D9003');
INSERT INTO "links" VALUES(160,3,'readings',39,X'96B96BBF1BE87DEC9CF9A3BBEFB217CA46EC251C78379E795545745AF361C246');
INSERT INTO "links" VALUES(161,3,'events',93,X'A318E2DCA7224E04EC32F974ABDDD31F7D12044FCFBE090B11A8F5AC10889146');
INSERT INTO "links" VALUES(162,3,'events',94,X'D9ED426E9FCF8F1F930F3EC5422E32886D819A86F130EE075AA8A04212BE82EE');
INSERT INTO "links" VALUES(163,3,'skipped_stops',1,X'3FE453C6D54C3E42B78E098CF23FC41A9344154D31590359B7AB386F147B75EA');
INSERT INTO "links" VALUES(164,3,'events',95,X'0C957A2C8A53250B041ADA7AC0B0EC66E0FCA74893255713A5E77F746B4B2C68');
INSERT INTO "links" VALUES(165,3,'events',96,X'A3D2996CA69E31F7684070EC5C2014F822CF928CF472BE1C346D9B8D2C8384D8');
INSERT INTO "links" VALUES(166,3,'readings',40,X'9ACBE011B50D8A03418AAB9D59DB1AE68273284B9E4785336476EEACA2029C50');
INSERT INTO "links" VALUES(167,3,'events',97,X'D1F18D61B0A6A8F14EE097F7775A3C6869F9EC25F30A9053311AFC4BC710C973');
INSERT INTO "links" VALUES(168,3,'events',98,X'A45958911D8B2C5D23967EC7D0214C6E269A35398BD627799CC7A71B64744FCD');
INSERT INTO "links" VALUES(169,3,'readings',41,X'8E26C4B330F193FE30FC7F1E110A83E02A1F35DF1FCBCE20468226EA34355E39');
INSERT INTO "links" VALUES(170,3,'events',99,X'9CED411BF69F872731CE43C7E86D4319CD810BB2F913204FE243D43AF3627189');
INSERT INTO "links" VALUES(171,3,'readings',42,X'DBE65F95C27FCE43D68DB9ABDCE1E85C73ECD3340423BB790B1508891592B1EE');
INSERT INTO "links" VALUES(172,3,'events',100,X'6808C16A9C18AAF56586B13F3233F208ABB1CBD6E8D028B6B070FAC1F6DEC27E');
INSERT INTO "links" VALUES(173,3,'readings',43,X'272F064F798EBC4E9E202CDCE2EBC09105AAB450533E858D1639007C9D591E87');
INSERT INTO "links" VALUES(174,3,'events',101,X'CB14B2AEC6ACE89B9C5D28F1828F6BB6DE1CDD8D3E50FFF55B715D62E2B034F1');
INSERT INTO "links" VALUES(175,3,'events',102,X'1E9FB0F8BBC9619F9A10C3EA9F51D97C28D5B3400F572A6F23ED64A5CFDED315');
INSERT INTO "links" VALUES(176,3,'added_stops',1,X'730EAC2E9A1C6DCE0EEFDCEDFDDE0CD8F3918B968DEA6A640C6E6DF20DE53226');
INSERT INTO "links" VALUES(177,3,'events',103,X'5B6BED6D94DE03C20D23D4B567AF3EE2E89D602CF75161F0023FE7FCB492084F');
INSERT INTO "links" VALUES(178,0,'request_keys',1,X'8198E21C86A66C87910A34C0C9FBCF08FA53C105D3F0830AF81BEB7024809077');
INSERT INTO "links" VALUES(179,4,'sessions',4,X'2B9B621D9F3E0B11BA50837A4B4868141F26B57535CD8759D13FD49B7AFF0333');
INSERT INTO "links" VALUES(180,4,'session_states',12,X'19A426AA800DB3A6A2990D9404FB7608BA5AEE1F5282A2B92742BB50E265EFE8');
INSERT INTO "links" VALUES(181,4,'events',104,X'C44D89F881617B714E545F0A085471C68025A4989DC6C492AF40751CA7B0623D');
INSERT INTO "links" VALUES(182,4,'ballbar_entries',1,X'2CE374D23CAB1F0155BC41E975A26CCFBBAEFBEE0E76CE2197F46209A0310B4B');
INSERT INTO "links" VALUES(183,4,'events',105,X'33C17B84BA46E50E93FC37C24DB296F818E6597CE28DA87CF189AB3359370097');
INSERT INTO "links" VALUES(184,4,'session_states',13,X'9E5571F7ED8DA32BFF9EE20D942C2DA7BC53FE8906614D25264DF84236DEF07A');
INSERT INTO "links" VALUES(185,4,'events',106,X'8300333A59AA17D5DA0471BAEBA86A9B71260E60EF72DCFF25E3B698385D67C8');
INSERT INTO "links" VALUES(186,4,'ballbar_answers',1,X'7ABC4A9956EACFF7AAD6CA2C5B4988BBCC2D9AEBE7C16134C5BAEC7AB84E261E');
INSERT INTO "links" VALUES(187,4,'ballbar_entries',2,X'86D1D6E548355D3F5453D1C6CB7EF70BBAC04C7B6FF44EBBD421013C676E0485');
INSERT INTO "links" VALUES(188,4,'events',107,X'79E7404607BAF0B0ABE72F873F792141DDE4F0385216B1AE3243E1B486386270');
INSERT INTO "links" VALUES(189,4,'ballbar_entries',3,X'70266F23D9FEC3BDE2C2197A8AC842ACA98395EB349E5CC3C5A6CC010FFDC36A');
INSERT INTO "links" VALUES(190,4,'events',108,X'E16BB2B8BE3C506ABBD5393C4C6A08CB842E6788F88501D90D2E60651CF4931F');
INSERT INTO "links" VALUES(191,4,'ballbar_entries',4,X'19D4EED5797F6B02AB0F2400E904465D3A64A69F9D1CB7519A5C03BABA43AB28');
INSERT INTO "links" VALUES(192,4,'events',109,X'D4939AD41762A39155B082B8C981D9BAAA285021088187E5E1A3959AD2127675');
INSERT INTO "links" VALUES(193,4,'ballbar_entries',5,X'F3F3BCCA09F22B0C1E30D41EC2803F0F5F2C968F1B5AAB94A240A0DDE6125AF1');
INSERT INTO "links" VALUES(194,4,'events',110,X'C96B3B8CFC899A4762EAE9E460C72E0B749117A166F3BD6B5D60C8873082E94C');
INSERT INTO "links" VALUES(195,4,'ballbar_entries',6,X'4C10F58BAE8577C4FE61F97D43DC03A970D58591301D06974705265D74A80591');
INSERT INTO "links" VALUES(196,4,'events',111,X'7020682124FDA69F02080D57B08F8ADFA0BC295C05291F00ABD826B2633B1D72');
INSERT INTO "links" VALUES(197,4,'ballbar_entries',7,X'B591F0A61225933CF7B398352694AE002CAF02278951D07F86578115557068DD');
INSERT INTO "links" VALUES(198,4,'events',112,X'DCEC303331FC35E479B0BECFDCFD4810C73F4C04D362B82E2EEDFA1096BA4ACB');
INSERT INTO "links" VALUES(199,4,'session_states',14,X'FBCF26D1D6D56432CDAAAC9418FC3759305A81D98B27C644B0919911AE2747E8');
INSERT INTO "links" VALUES(200,4,'events',113,X'84D0355A2E78BD02429B272C6AA14EA0A9C728D1BE8FE1018DB393E5C5A8865E');
INSERT INTO "links" VALUES(201,5,'sessions',5,X'3A08EDA578B3CA7B991FE25388375D997360C23F97C8C42C2EB7797F3C62C979');
INSERT INTO "links" VALUES(202,5,'session_states',15,X'39255BFD4E756A356664ACF9A3FA52E1F97C8FD9DE630C08FC5F887EABC31D49');
INSERT INTO "links" VALUES(203,5,'events',114,X'13BC0A3E11F867F6021D57B67CEA0440032C5B32568A3DB0386334A85424964A');
CREATE TABLE models (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	identification_id INTEGER, 
	diagnosis_id INTEGER, 
	robot TEXT NOT NULL, 
	document JSON NOT NULL, 
	CHECK ((identification_id IS NULL) <> (diagnosis_id IS NULL)), 
	FOREIGN KEY(identification_id) REFERENCES identifications (id), 
	FOREIGN KEY(diagnosis_id) REFERENCES diagnoses (id)
);
CREATE TABLE notes (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	session_id INTEGER NOT NULL, 
	text TEXT NOT NULL, 
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
INSERT INTO "notes" VALUES(1,'2026-11-22T17:41:50.303+00:00',1,'The tracker is Leica AT401, serial 390001, firmware 3.8.');
INSERT INTO "notes" VALUES(2,'2026-11-22T17:41:50.312+00:00',1,'The robot is ABB IRB 120, serial 120-1, firmware 6.08.');
INSERT INTO "notes" VALUES(3,'2026-11-22T17:41:50.315+00:00',1,'The robot was told to move at 500 mm/s and 20 deg/s at most, and cannot be asked whether it keeps to that.');
INSERT INTO "notes" VALUES(4,'2026-11-22T17:41:50.436+00:00',1,'The tracker''s scale agrees with the certified lengths: -0.0 ppm (u = 1.8 ppm).');
INSERT INTO "notes" VALUES(5,'2026-11-22T17:41:50.567+00:00',2,'The tracker is Leica AT401, serial 390001, firmware 3.8.');
INSERT INTO "notes" VALUES(6,'2026-11-22T17:41:50.573+00:00',2,'The robot is ABB IRB 120, serial 120-1, firmware 6.08.');
INSERT INTO "notes" VALUES(7,'2026-11-22T17:41:50.575+00:00',2,'The robot was told to move at 500 mm/s and 20 deg/s at most, and cannot be asked whether it keeps to that.');
INSERT INTO "notes" VALUES(8,'2026-11-22T17:41:50.694+00:00',2,'The tracker''s scale agrees with the certified lengths: -0.0 ppm (u = 1.8 ppm).');
INSERT INTO "notes" VALUES(9,'2026-11-22T17:41:50.823+00:00',3,'The tracker is Leica AT401, serial 390001, firmware 3.8.');
INSERT INTO "notes" VALUES(10,'2026-11-22T17:41:50.831+00:00',3,'The robot is ABB IRB 120, serial 120-1, firmware 6.08.');
INSERT INTO "notes" VALUES(11,'2026-11-22T17:41:50.835+00:00',3,'The robot was told to move at 500 mm/s and 20 deg/s at most, and cannot be asked whether it keeps to that.');
INSERT INTO "notes" VALUES(12,'2026-11-22T17:41:50.947+00:00',3,'The tracker''s scale agrees with the certified lengths: -0.0 ppm (u = 1.8 ppm).');
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
INSERT INTO "readings" VALUES(1,'2026-11-22T17:41:50.390+00:00',1,'fixed_nest',NULL,1,1052.0,NULL,'{"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1052.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(2,'2026-11-22T17:41:50.398+00:00',1,'fixed_nest',NULL,1,1053.0,NULL,'{"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1053.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(3,'2026-11-22T17:41:50.405+00:00',1,'fixed_nest',NULL,2,1055.0,NULL,'{"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1055.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(4,'2026-11-22T17:41:50.410+00:00',1,'fixed_nest',NULL,2,1056.0,NULL,'{"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1056.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(5,'2026-11-22T17:41:50.419+00:00',1,'fixed_nest',NULL,3,1058.0,NULL,'{"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1058.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(6,'2026-11-22T17:41:50.423+00:00',1,'fixed_nest',NULL,3,1059.0,NULL,'{"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1059.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(7,'2026-11-22T17:41:50.446+00:00',1,'fixed_nest',NULL,1,1061.0,NULL,'{"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1061.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(8,'2026-11-22T17:41:50.452+00:00',1,'fixed_nest',NULL,2,1063.0,NULL,'{"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1063.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(9,'2026-11-22T17:41:50.458+00:00',1,'fixed_nest',NULL,3,1065.0,NULL,'{"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1065.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(10,'2026-11-22T17:41:50.475+00:00',1,'point',1,1,1074.5,NULL,'{"config": 1, "nest": 1, "commanded_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "reported_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1074.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1378.7820983216018, 1466.1745914894477, -381.52523986964144], "position_world_mm": [694.5767607633579, -54.48320661771845, 114.07272073957677], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(11,'2026-11-22T17:41:50.485+00:00',1,'point',2,1,1083.5,NULL,'{"config": 2, "nest": 1, "commanded_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "reported_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1083.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1233.4342306064098, 1930.1553461336957, -287.7891580747927], "position_world_mm": [332.79425776967855, -380.1891529381973, 204.73502502840057], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(12,'2026-11-22T17:41:50.504+00:00',1,'point',3,1,1092.5,NULL,'{"config": 3, "nest": 1, "commanded_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "reported_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1092.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1212.9485277061294, 2233.424884231922, -35.26876839619594], "position_world_mm": [64.54916662792948, -526.2768402537183, 455.45714742332984], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(13,'2026-11-22T17:41:50.513+00:00',1,'fixed_nest',NULL,1,1094.5,NULL,'{"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1094.5, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(14,'2026-11-22T17:41:50.518+00:00',1,'fixed_nest',NULL,2,1096.5,NULL,'{"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1096.5, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(15,'2026-11-22T17:41:50.531+00:00',1,'fixed_nest',NULL,3,1098.5,NULL,'{"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1098.5, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(16,'2026-11-22T17:41:50.653+00:00',2,'fixed_nest',NULL,1,1052.0,NULL,'{"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1052.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(17,'2026-11-22T17:41:50.664+00:00',2,'fixed_nest',NULL,1,1053.0,NULL,'{"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1053.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(18,'2026-11-22T17:41:50.669+00:00',2,'fixed_nest',NULL,2,1055.0,NULL,'{"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1055.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(19,'2026-11-22T17:41:50.672+00:00',2,'fixed_nest',NULL,2,1056.0,NULL,'{"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1056.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(20,'2026-11-22T17:41:50.679+00:00',2,'fixed_nest',NULL,3,1058.0,NULL,'{"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1058.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(21,'2026-11-22T17:41:50.683+00:00',2,'fixed_nest',NULL,3,1059.0,NULL,'{"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1059.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(22,'2026-11-22T17:41:50.701+00:00',2,'fixed_nest',NULL,1,1061.0,NULL,'{"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1061.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(23,'2026-11-22T17:41:50.711+00:00',2,'fixed_nest',NULL,2,1063.0,NULL,'{"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1063.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(24,'2026-11-22T17:41:50.719+00:00',2,'fixed_nest',NULL,3,1065.0,NULL,'{"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1065.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(25,'2026-11-22T17:41:50.734+00:00',2,'point',1,1,1074.5,NULL,'{"config": 1, "nest": 1, "commanded_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "reported_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1074.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1378.7820983216018, 1466.1745914894477, -381.52523986964144], "position_world_mm": [694.5767607633579, -54.48320661771845, 114.07272073957677], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(26,'2026-11-22T17:41:50.746+00:00',2,'point',2,1,1083.5,NULL,'{"config": 2, "nest": 1, "commanded_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "reported_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1083.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1233.4342306064098, 1930.1553461336957, -287.7891580747927], "position_world_mm": [332.79425776967855, -380.1891529381973, 204.73502502840057], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(27,'2026-11-22T17:41:50.763+00:00',2,'fixed_nest',NULL,1,1085.5,NULL,'{"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1085.5, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(28,'2026-11-22T17:41:50.773+00:00',2,'fixed_nest',NULL,2,1087.5,NULL,'{"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1087.5, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(29,'2026-11-22T17:41:50.778+00:00',2,'fixed_nest',NULL,3,1089.5,NULL,'{"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1089.5, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(30,'2026-11-22T17:41:50.903+00:00',3,'fixed_nest',NULL,1,1052.0,NULL,'{"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1052.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(31,'2026-11-22T17:41:50.908+00:00',3,'fixed_nest',NULL,1,1053.0,NULL,'{"phase": "registration", "fixed_nest": 1, "face": 1, "time_s": 1053.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(32,'2026-11-22T17:41:50.921+00:00',3,'fixed_nest',NULL,2,1055.0,NULL,'{"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1055.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(33,'2026-11-22T17:41:50.924+00:00',3,'fixed_nest',NULL,2,1056.0,NULL,'{"phase": "registration", "fixed_nest": 2, "face": 1, "time_s": 1056.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(34,'2026-11-22T17:41:50.933+00:00',3,'fixed_nest',NULL,3,1058.0,NULL,'{"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1058.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(35,'2026-11-22T17:41:50.940+00:00',3,'fixed_nest',NULL,3,1059.0,NULL,'{"phase": "registration", "fixed_nest": 3, "face": 1, "time_s": 1059.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": null, "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(36,'2026-11-22T17:41:50.961+00:00',3,'fixed_nest',NULL,1,1061.0,NULL,'{"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1061.0, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(37,'2026-11-22T17:41:50.963+00:00',3,'fixed_nest',NULL,2,1063.0,NULL,'{"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1063.0, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(38,'2026-11-22T17:41:50.966+00:00',3,'fixed_nest',NULL,3,1065.0,NULL,'{"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1065.0, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(39,'2026-11-22T17:41:50.970+00:00',3,'point',1,1,1074.5,NULL,'{"config": 1, "nest": 1, "commanded_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "reported_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1074.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1378.7820983216018, 1466.1745914894477, -381.52523986964144], "position_world_mm": [694.5767607633579, -54.48320661771845, 114.07272073957677], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(40,'2026-11-22T17:41:50.993+00:00',3,'point',3,1,1090.5,NULL,'{"config": 3, "nest": 1, "commanded_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "reported_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "direction": [1, 1, 1, 1, 1, 1], "time_s": 1090.5, "temperature_c": 23.1, "attachment": 1, "position_tracker_mm": [1212.9485277061294, 2233.424884231922, -35.26876839619594], "position_world_mm": [64.54916662792948, -526.2768402537183, 455.45714742332984], "standard_uncertainty_mm": 0.0011547005383792514, "rms_mm": 0.02, "samples": 100, "repeat_of": null, "covariance_mm2": null, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(41,'2026-11-22T17:41:50.996+00:00',3,'fixed_nest',NULL,1,1092.5,NULL,'{"phase": "reference", "fixed_nest": 1, "face": 1, "time_s": 1092.5, "position_tracker_mm": [1921.9993219222351, 1322.0910962622766, -497.98969840196554], "position_world_mm": [600.0000000000005, 500.0, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(42,'2026-11-22T17:41:50.998+00:00',3,'fixed_nest',NULL,2,1094.5,NULL,'{"phase": "reference", "fixed_nest": 2, "face": 1, "time_s": 1094.5, "position_tracker_mm": [1012.7049384108515, 1738.2145451605331, -492.9897592350528], "position_world_mm": [600.0, -500.0000000000001, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
INSERT INTO "readings" VALUES(43,'2026-11-22T17:41:51.011+00:00',3,'fixed_nest',NULL,3,1096.5,NULL,'{"phase": "reference", "fixed_nest": 3, "face": 1, "time_s": 1096.5, "position_tracker_mm": [2317.33565393028, 2185.9167410954446, -494.1897085352907], "position_world_mm": [-350.00000000000045, 500.0000000000002, 0.0], "standard_uncertainty_mm": 0.0011547005383792514, "instrument_serial": "390001"}');
CREATE TABLE registrations (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	session_id INTEGER NOT NULL, 
	document JSON NOT NULL, 
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
INSERT INTO "registrations" VALUES(1,'2026-11-22T17:41:50.429+00:00',1,'{"rotation": [[-0.41614350737688893, -0.9092901524559666, -0.003999989333341914], [0.9092943835113836, -0.4161234488982564, -0.0049999391669127225], [0.0028819060904061527, -0.0057178600565033905, 0.999979500136708]], "translation_mm": [2600.000000000001, -700.0, 500.0000000000001], "covariance": [[1.4209373631187038e-06, -1.4892685063512953e-07, 0.0, 0.0, 0.0, 5.256241787122206e-10], [-1.4892685063512958e-07, 1.5865089794130525e-06, 0.0, 0.0, 0.0, -8.935611038107757e-10], [0.0, 0.0, 2.664819944598339e-06, -2.526315789473685e-09, 3.2132963988919673e-09, 0.0], [0.0, 0.0, -2.526315789473685e-09, 8.000000000000001e-12, -4.210526315789473e-12, 0.0], [0.0, 0.0, 3.2132963988919673e-09, -4.2105263157894725e-12, 8.864265927977839e-12, 0.0], [5.256241787122206e-10, -8.935611038107754e-10, 0.0, 0.0, 0.0, 3.1537450722733247e-12]], "rms_mm": 2.6254850544756925e-13, "two_face_mm": null, "scale": 0.9999999999999997, "scale_standard_uncertainty": 1.775878676113129e-06, "instrument_serial": "390001"}');
INSERT INTO "registrations" VALUES(2,'2026-11-22T17:41:50.691+00:00',2,'{"rotation": [[-0.41614350737688893, -0.9092901524559666, -0.003999989333341914], [0.9092943835113836, -0.4161234488982564, -0.0049999391669127225], [0.0028819060904061527, -0.0057178600565033905, 0.999979500136708]], "translation_mm": [2600.000000000001, -700.0, 500.0000000000001], "covariance": [[1.4209373631187038e-06, -1.4892685063512953e-07, 0.0, 0.0, 0.0, 5.256241787122206e-10], [-1.4892685063512958e-07, 1.5865089794130525e-06, 0.0, 0.0, 0.0, -8.935611038107757e-10], [0.0, 0.0, 2.664819944598339e-06, -2.526315789473685e-09, 3.2132963988919673e-09, 0.0], [0.0, 0.0, -2.526315789473685e-09, 8.000000000000001e-12, -4.210526315789473e-12, 0.0], [0.0, 0.0, 3.2132963988919673e-09, -4.2105263157894725e-12, 8.864265927977839e-12, 0.0], [5.256241787122206e-10, -8.935611038107754e-10, 0.0, 0.0, 0.0, 3.1537450722733247e-12]], "rms_mm": 2.6254850544756925e-13, "two_face_mm": null, "scale": 0.9999999999999997, "scale_standard_uncertainty": 1.775878676113129e-06, "instrument_serial": "390001"}');
INSERT INTO "registrations" VALUES(3,'2026-11-22T17:41:50.944+00:00',3,'{"rotation": [[-0.41614350737688893, -0.9092901524559666, -0.003999989333341914], [0.9092943835113836, -0.4161234488982564, -0.0049999391669127225], [0.0028819060904061527, -0.0057178600565033905, 0.999979500136708]], "translation_mm": [2600.000000000001, -700.0, 500.0000000000001], "covariance": [[1.4209373631187038e-06, -1.4892685063512953e-07, 0.0, 0.0, 0.0, 5.256241787122206e-10], [-1.4892685063512958e-07, 1.5865089794130525e-06, 0.0, 0.0, 0.0, -8.935611038107757e-10], [0.0, 0.0, 2.664819944598339e-06, -2.526315789473685e-09, 3.2132963988919673e-09, 0.0], [0.0, 0.0, -2.526315789473685e-09, 8.000000000000001e-12, -4.210526315789473e-12, 0.0], [0.0, 0.0, 3.2132963988919673e-09, -4.2105263157894725e-12, 8.864265927977839e-12, 0.0], [5.256241787122206e-10, -8.935611038107754e-10, 0.0, 0.0, 0.0, 3.1537450722733247e-12]], "rms_mm": 2.6254850544756925e-13, "two_face_mm": null, "scale": 0.9999999999999997, "scale_standard_uncertainty": 1.775878676113129e-06, "instrument_serial": "390001"}');
CREATE TABLE request_keys (
	"key" TEXT NOT NULL, 
	recorded_at TEXT NOT NULL, 
	fingerprint TEXT NOT NULL, 
	resource TEXT NOT NULL, 
	resource_id INTEGER NOT NULL, 
	PRIMARY KEY ("key")
);
INSERT INTO "request_keys" VALUES('more','2026-11-22T17:41:51.017+00:00','f','added stops',1);
CREATE TABLE session_states (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	session_id INTEGER NOT NULL, 
	state TEXT NOT NULL, 
	reason TEXT NOT NULL, 
	person TEXT, 
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
INSERT INTO "session_states" VALUES(1,'2026-11-22T17:41:50.258+00:00',1,'planned','The plan is stored; nothing has moved.',NULL);
INSERT INTO "session_states" VALUES(2,'2026-11-22T17:41:50.277+00:00',1,'awaiting_confirmation','The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?',NULL);
INSERT INTO "session_states" VALUES(3,'2026-11-22T17:41:50.287+00:00',1,'running','Eva had the session go on.','Eva');
INSERT INTO "session_states" VALUES(4,'2026-11-22T17:41:50.538+00:00',1,'finished','Every configuration was measured or skipped.',NULL);
INSERT INTO "session_states" VALUES(5,'2026-11-22T17:41:50.547+00:00',2,'planned','The plan is stored; nothing has moved.',NULL);
INSERT INTO "session_states" VALUES(6,'2026-11-22T17:41:50.552+00:00',2,'awaiting_confirmation','The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?',NULL);
INSERT INTO "session_states" VALUES(7,'2026-11-22T17:41:50.559+00:00',2,'running','Eva had the session go on.','Eva');
INSERT INTO "session_states" VALUES(8,'2026-11-22T17:41:50.790+00:00',2,'finished','Every configuration was measured or skipped.',NULL);
INSERT INTO "session_states" VALUES(9,'2026-11-22T17:41:50.798+00:00',3,'planned','The plan is stored; nothing has moved.',NULL);
INSERT INTO "session_states" VALUES(10,'2026-11-22T17:41:50.804+00:00',3,'awaiting_confirmation','The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?',NULL);
INSERT INTO "session_states" VALUES(11,'2026-11-22T17:41:50.811+00:00',3,'running','Eva had the session go on.','Eva');
INSERT INTO "session_states" VALUES(12,'2026-11-22T17:41:51.019+00:00',4,'planned','The plan is stored; nothing has moved.',NULL);
INSERT INTO "session_states" VALUES(13,'2026-11-22T17:41:51.022+00:00',4,'running','Eva started the session.','Eva');
INSERT INTO "session_states" VALUES(14,'2026-11-22T17:41:51.060+00:00',4,'paused','Lunch: an hour.','Ada');
INSERT INTO "session_states" VALUES(15,'2026-11-22T17:41:51.064+00:00',5,'planned','The plan is stored; nothing has moved.',NULL);
CREATE TABLE sessions (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	name TEXT NOT NULL, 
	role TEXT NOT NULL, 
	setup JSON NOT NULL, 
	"plan" JSON NOT NULL
);
INSERT INTO "sessions" VALUES(1,'2026-11-22T17:41:50.257+00:00','spring','calibration','{"cell": {"name": "bench", "robot_key": "irb120", "robot": {"name": "IRB 120", "joints": [{"alpha_rad": 0.0, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 290.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": -1.5707963267948966, "d_mm": 0.0, "sign": 1}, {"alpha_rad": 0.0, "a_mm": 270.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 70.0, "theta_offset_rad": 0.0, "d_mm": 302.0, "sign": 1}, {"alpha_rad": 1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 3.141592653589793, "d_mm": 72.0, "sign": 1}], "masses": [], "gear_ratios": null, "typical_compliances_rad_per_n_mm": null, "repeatability_mm": 0.0, "calibration_ranges": [{"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": 0.0, "upper_rad": 1.5707963267948966}, {"lower_rad": -1.3962634015954636, "upper_rad": 0.8726646259971648}, {"lower_rad": -2.6179938779914944, "upper_rad": 2.6179938779914944}, {"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": -3.141592653589793, "upper_rad": 3.141592653589793}], "rated_payload_kg": null, "source": "", "joint_limits": null}, "robot_serial_number": "120-1", "base_nominal": {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 0.0, "rx_rad": 0.0, "ry_rad": 0.0, "rz_rad": 0.0}, "nests": [{"centre_mm": [0.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [75.0, 93.675, 215.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [150.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}], "tool": null, "fixed_nests": [{"centre_mm": [600.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [600.0, -500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [-350.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}], "fixed_nests_seen_mm": null, "world": null, "certified_lengths": [], "tracker_position_mm": [2600.0, -700.0, 500.0], "limits": {"joints": null, "calibration": null, "floor_z_mm": null, "reference_mm": 0.1, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349}, "conditions": {"load": "", "warm_up": "", "notes": []}, "devices": [], "simulated": null, "ballbar": null, "people": []}, "attachment": 1}','{"role": "calibration", "stops": [{"config": 1, "joints_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "nest": 1, "repeat_of": null}, {"config": 2, "joints_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "nest": 1, "repeat_of": null}, {"config": 3, "joints_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "nest": 1, "repeat_of": null}], "approach_offset_rad": -0.0872664626, "settle_s": 4.0, "measure_s": 1.0, "search_radius_mm": 10.0, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349, "reference_every": 3, "reference_limit_mm": 0.1, "registration_readings": 2, "two_face_check": false, "two_face_limit_mm": 0.1, "joint_tolerance_rad": 0.00035, "rms_limit_mm": 0.1, "failures_in_a_row": 3}');
INSERT INTO "sessions" VALUES(2,'2026-11-22T17:41:50.546+00:00','spring, validation','validation','{"cell": {"name": "bench", "robot_key": "irb120", "robot": {"name": "IRB 120", "joints": [{"alpha_rad": 0.0, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 290.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": -1.5707963267948966, "d_mm": 0.0, "sign": 1}, {"alpha_rad": 0.0, "a_mm": 270.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 70.0, "theta_offset_rad": 0.0, "d_mm": 302.0, "sign": 1}, {"alpha_rad": 1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 3.141592653589793, "d_mm": 72.0, "sign": 1}], "masses": [], "gear_ratios": null, "typical_compliances_rad_per_n_mm": null, "repeatability_mm": 0.0, "calibration_ranges": [{"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": 0.0, "upper_rad": 1.5707963267948966}, {"lower_rad": -1.3962634015954636, "upper_rad": 0.8726646259971648}, {"lower_rad": -2.6179938779914944, "upper_rad": 2.6179938779914944}, {"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": -3.141592653589793, "upper_rad": 3.141592653589793}], "rated_payload_kg": null, "source": "", "joint_limits": null}, "robot_serial_number": "120-1", "base_nominal": {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 0.0, "rx_rad": 0.0, "ry_rad": 0.0, "rz_rad": 0.0}, "nests": [{"centre_mm": [0.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [75.0, 93.675, 215.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [150.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}], "tool": null, "fixed_nests": [{"centre_mm": [600.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [600.0, -500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [-350.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}], "fixed_nests_seen_mm": null, "world": null, "certified_lengths": [], "tracker_position_mm": [2600.0, -700.0, 500.0], "limits": {"joints": null, "calibration": null, "floor_z_mm": null, "reference_mm": 0.1, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349}, "conditions": {"load": "", "warm_up": "", "notes": []}, "devices": [], "simulated": null, "ballbar": null, "people": []}, "attachment": 1}','{"role": "validation", "stops": [{"config": 1, "joints_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "nest": 1, "repeat_of": null}, {"config": 2, "joints_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "nest": 1, "repeat_of": null}], "approach_offset_rad": -0.0872664626, "settle_s": 4.0, "measure_s": 1.0, "search_radius_mm": 10.0, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349, "reference_every": 3, "reference_limit_mm": 0.1, "registration_readings": 2, "two_face_check": false, "two_face_limit_mm": 0.1, "joint_tolerance_rad": 0.00035, "rms_limit_mm": 0.1, "failures_in_a_row": 3}');
INSERT INTO "sessions" VALUES(3,'2026-11-22T17:41:50.797+00:00','killed','calibration','{"cell": {"name": "bench", "robot_key": "irb120", "robot": {"name": "IRB 120", "joints": [{"alpha_rad": 0.0, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 290.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": -1.5707963267948966, "d_mm": 0.0, "sign": 1}, {"alpha_rad": 0.0, "a_mm": 270.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 70.0, "theta_offset_rad": 0.0, "d_mm": 302.0, "sign": 1}, {"alpha_rad": 1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 3.141592653589793, "d_mm": 72.0, "sign": 1}], "masses": [], "gear_ratios": null, "typical_compliances_rad_per_n_mm": null, "repeatability_mm": 0.0, "calibration_ranges": [{"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": 0.0, "upper_rad": 1.5707963267948966}, {"lower_rad": -1.3962634015954636, "upper_rad": 0.8726646259971648}, {"lower_rad": -2.6179938779914944, "upper_rad": 2.6179938779914944}, {"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": -3.141592653589793, "upper_rad": 3.141592653589793}], "rated_payload_kg": null, "source": "", "joint_limits": null}, "robot_serial_number": "120-1", "base_nominal": {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 0.0, "rx_rad": 0.0, "ry_rad": 0.0, "rz_rad": 0.0}, "nests": [{"centre_mm": [0.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [75.0, 93.675, 215.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [150.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}], "tool": null, "fixed_nests": [{"centre_mm": [600.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [600.0, -500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [-350.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}], "fixed_nests_seen_mm": null, "world": null, "certified_lengths": [], "tracker_position_mm": [2600.0, -700.0, 500.0], "limits": {"joints": null, "calibration": null, "floor_z_mm": null, "reference_mm": 0.1, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349}, "conditions": {"load": "", "warm_up": "", "notes": []}, "devices": [], "simulated": null, "ballbar": null, "people": []}, "attachment": 1}','{"role": "calibration", "stops": [{"config": 1, "joints_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "nest": 1, "repeat_of": null}, {"config": 2, "joints_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "nest": 1, "repeat_of": null}, {"config": 3, "joints_rad": [-1.301721532510402, 0.37198107390759205, 0.42177069030562464, 0.4301994148396626, -1.2750824758400765, -0.4201758265523301], "nest": 1, "repeat_of": null}, {"config": 4, "joints_rad": [1.3919018063942539, 0.8031914417498227, 0.8187633040456361, -2.1947374466317733, 0.33726829311560524, -0.7760576782802868], "nest": 1, "repeat_of": null}, {"config": 5, "joints_rad": [0.9581949445618942, 1.2691104247858522, -0.22702679281205174, -1.1215413512069445, -1.4013680283897472, -0.7328149346083426], "nest": 1, "repeat_of": null}], "approach_offset_rad": -0.0872664626, "settle_s": 4.0, "measure_s": 1.0, "search_radius_mm": 10.0, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349, "reference_every": 3, "reference_limit_mm": 0.1, "registration_readings": 2, "two_face_check": false, "two_face_limit_mm": 0.1, "joint_tolerance_rad": 0.00035, "rms_limit_mm": 0.1, "failures_in_a_row": 3}');
INSERT INTO "sessions" VALUES(4,'2026-11-22T17:41:51.019+00:00','six legs','ballbar','{"cell": {"name": "bench", "robot_key": "irb120", "robot": {"name": "IRB 120", "joints": [{"alpha_rad": 0.0, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 290.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": -1.5707963267948966, "d_mm": 0.0, "sign": 1}, {"alpha_rad": 0.0, "a_mm": 270.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 70.0, "theta_offset_rad": 0.0, "d_mm": 302.0, "sign": 1}, {"alpha_rad": 1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 3.141592653589793, "d_mm": 72.0, "sign": 1}], "masses": [], "gear_ratios": null, "typical_compliances_rad_per_n_mm": null, "repeatability_mm": 0.0, "calibration_ranges": [{"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": 0.0, "upper_rad": 1.5707963267948966}, {"lower_rad": -1.3962634015954636, "upper_rad": 0.8726646259971648}, {"lower_rad": -2.6179938779914944, "upper_rad": 2.6179938779914944}, {"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": -3.141592653589793, "upper_rad": 3.141592653589793}], "rated_payload_kg": null, "source": "", "joint_limits": null}, "robot_serial_number": "120-1", "base_nominal": {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 0.0, "rx_rad": 0.0, "ry_rad": 0.0, "rz_rad": 0.0}, "nests": [{"centre_mm": [0.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [75.0, 93.675, 215.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [150.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}], "tool": null, "fixed_nests": [{"centre_mm": [600.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [600.0, -500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [-350.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}], "fixed_nests_seen_mm": null, "world": null, "certified_lengths": [], "tracker_position_mm": [2600.0, -700.0, 500.0], "limits": {"joints": null, "calibration": null, "floor_z_mm": null, "reference_mm": 0.1, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349}, "conditions": {"load": "", "warm_up": "", "notes": []}, "devices": [], "simulated": null, "ballbar": null, "people": []}, "attachment": 1}','{"placements": [{"number": 1, "frame": {"x_mm": 400.0, "y_mm": 0.0, "z_mm": 0.0, "rx_rad": 0.0, "ry_rad": 0.0, "rz_rad": 0.0}, "cups_mm": [[400.0, 0.0, 0.0], [700.0, 0.0, 0.0], [550.0, 260.0, 0.0]], "setups": [{"base_point": 1, "joints_rad": [0.1, 0.1, 0.1, 0.1, 0.1, 0.1], "via_rad": []}, {"base_point": 2, "joints_rad": [0.2, 0.2, 0.2, 0.2, 0.2, 0.2], "via_rad": []}, {"base_point": 3, "joints_rad": [0.30000000000000004, 0.30000000000000004, 0.30000000000000004, 0.30000000000000004, 0.30000000000000004, 0.30000000000000004], "via_rad": []}], "poses": [{"config": 1, "placement": 1, "joints_rad": [0.2, 0.2, 0.2, 0.2, 0.2, 0.2], "legs": [[1, 1], [1, 2], [2, 2], [2, 3], [3, 3], [3, 1]], "aimed_mm": null, "via_rad": [], "assembly": ""}, {"config": 2, "placement": 1, "joints_rad": [0.4, 0.4, 0.4, 0.4, 0.4, 0.4], "legs": [[1, 1], [1, 2], [2, 2], [2, 3], [3, 3], [3, 1]], "aimed_mm": null, "via_rad": [], "assembly": ""}], "away": null}], "precalibrate_after": 12, "check_at_end": false, "settle_s": 2.0, "stable_s": 1.0, "stable_mm": 0.002, "state_age_s": 2.0, "tool_speed_mm_s": 250.0, "orientation_speed_rad_s": 0.349, "joint_tolerance_rad": 0.00035}');
INSERT INTO "sessions" VALUES(5,'2026-11-22T17:41:51.064+00:00','not begun','calibration','{"cell": {"name": "bench", "robot_key": "irb120", "robot": {"name": "IRB 120", "joints": [{"alpha_rad": 0.0, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 290.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": -1.5707963267948966, "d_mm": 0.0, "sign": 1}, {"alpha_rad": 0.0, "a_mm": 270.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 70.0, "theta_offset_rad": 0.0, "d_mm": 302.0, "sign": 1}, {"alpha_rad": 1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 0.0, "d_mm": 0.0, "sign": 1}, {"alpha_rad": -1.5707963267948966, "a_mm": 0.0, "theta_offset_rad": 3.141592653589793, "d_mm": 72.0, "sign": 1}], "masses": [], "gear_ratios": null, "typical_compliances_rad_per_n_mm": null, "repeatability_mm": 0.0, "calibration_ranges": [{"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": 0.0, "upper_rad": 1.5707963267948966}, {"lower_rad": -1.3962634015954636, "upper_rad": 0.8726646259971648}, {"lower_rad": -2.6179938779914944, "upper_rad": 2.6179938779914944}, {"lower_rad": -1.5707963267948966, "upper_rad": 1.5707963267948966}, {"lower_rad": -3.141592653589793, "upper_rad": 3.141592653589793}], "rated_payload_kg": null, "source": "", "joint_limits": null}, "robot_serial_number": "120-1", "base_nominal": {"x_mm": 0.0, "y_mm": 0.0, "z_mm": 0.0, "rx_rad": 0.0, "ry_rad": 0.0, "rz_rad": 0.0}, "nests": [{"centre_mm": [0.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [75.0, 93.675, 215.0], "standard_uncertainty_mm": null, "facing": null}, {"centre_mm": [150.0, 0.0, 125.0], "standard_uncertainty_mm": null, "facing": null}], "tool": null, "fixed_nests": [{"centre_mm": [600.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [600.0, -500.0, 0.0], "standard_uncertainty_mm": 0.002}, {"centre_mm": [-350.0, 500.0, 0.0], "standard_uncertainty_mm": 0.002}], "fixed_nests_seen_mm": null, "world": null, "certified_lengths": [], "tracker_position_mm": [2600.0, -700.0, 500.0], "limits": {"joints": null, "calibration": null, "floor_z_mm": null, "reference_mm": 0.1, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349}, "conditions": {"load": "", "warm_up": "", "notes": []}, "devices": [], "simulated": null, "ballbar": null, "people": []}, "attachment": 1}','{"role": "calibration", "stops": [{"config": 1, "joints_rad": [0.03713872931182216, 1.492984882940679, -1.0691756158489878, 2.3491230119391457, -0.5911489280005173, -0.4817541292647971], "nest": 1, "repeat_of": null}, {"config": 2, "joints_rad": [-0.7489175677472975, 0.46886879165571355, 0.45115620202626405, -2.136723130392486, 0.3144750769941729, 1.4360881438650939], "nest": 1, "repeat_of": null}], "approach_offset_rad": -0.0872664626, "settle_s": 4.0, "measure_s": 1.0, "search_radius_mm": 10.0, "tool_speed_mm_s": 500.0, "orientation_speed_rad_s": 0.349, "reference_every": 3, "reference_limit_mm": 0.1, "registration_readings": 2, "two_face_check": false, "two_face_limit_mm": 0.1, "joint_tolerance_rad": 0.00035, "rms_limit_mm": 0.1, "failures_in_a_row": 3}');
CREATE TABLE skipped_stops (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	recorded_at TEXT NOT NULL, 
	session_id INTEGER NOT NULL, 
	document JSON NOT NULL, 
	FOREIGN KEY(session_id) REFERENCES sessions (id)
);
INSERT INTO "skipped_stops" VALUES(1,'2026-11-22T17:41:50.979+00:00',3,'{"config": 2, "time_s": 1081.5, "reason": "no reflector near nest 1"}');
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
);
CREATE TRIGGER sessions_no_update BEFORE UPDATE ON sessions BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER sessions_no_delete BEFORE DELETE ON sessions BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_session_states_session_id ON session_states (session_id, id);
CREATE TRIGGER session_states_no_update BEFORE UPDATE ON session_states BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER session_states_no_delete BEFORE DELETE ON session_states BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_readings_session_id ON readings (session_id, id);
CREATE TRIGGER readings_no_update BEFORE UPDATE ON readings BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER readings_no_delete BEFORE DELETE ON readings BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_skipped_stops_session_id ON skipped_stops (session_id, id);
CREATE TRIGGER skipped_stops_no_update BEFORE UPDATE ON skipped_stops BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER skipped_stops_no_delete BEFORE DELETE ON skipped_stops BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_registrations_session_id ON registrations (session_id, id);
CREATE TRIGGER registrations_no_update BEFORE UPDATE ON registrations BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER registrations_no_delete BEFORE DELETE ON registrations BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_notes_session_id ON notes (session_id, id);
CREATE TRIGGER notes_no_update BEFORE UPDATE ON notes BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER notes_no_delete BEFORE DELETE ON notes BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER campaigns_no_update BEFORE UPDATE ON campaigns BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER campaigns_no_delete BEFORE DELETE ON campaigns BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER jobs_no_update BEFORE UPDATE ON jobs BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER jobs_no_delete BEFORE DELETE ON jobs BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER job_states_no_update BEFORE UPDATE ON job_states BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER job_states_no_delete BEFORE DELETE ON job_states BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_job_states_job_id ON job_states (job_id, id);
CREATE TRIGGER identifications_no_update BEFORE UPDATE ON identifications BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER identifications_no_delete BEFORE DELETE ON identifications BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER validations_no_update BEFORE UPDATE ON validations BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER validations_no_delete BEFORE DELETE ON validations BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_events_session_id ON events (session_id, kind, id);
CREATE INDEX ix_events_job_id ON events (job_id, kind, id);
CREATE TRIGGER events_no_update BEFORE UPDATE ON events BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER events_no_delete BEFORE DELETE ON events BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER request_keys_no_update BEFORE UPDATE ON request_keys BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER request_keys_no_delete BEFORE DELETE ON request_keys BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER diagnoses_no_update BEFORE UPDATE ON diagnoses BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER diagnoses_no_delete BEFORE DELETE ON diagnoses BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER models_no_update BEFORE UPDATE ON models BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER models_no_delete BEFORE DELETE ON models BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_added_stops_session_id ON added_stops (session_id, id);
CREATE TRIGGER added_stops_no_update BEFORE UPDATE ON added_stops BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER added_stops_no_delete BEFORE DELETE ON added_stops BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_ballbar_entries_session_id ON ballbar_entries (session_id, id);
CREATE TRIGGER ballbar_entries_no_update BEFORE UPDATE ON ballbar_entries BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER ballbar_entries_no_delete BEFORE DELETE ON ballbar_entries BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER ballbar_answers_no_update BEFORE UPDATE ON ballbar_answers BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER ballbar_answers_no_delete BEFORE DELETE ON ballbar_answers BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE INDEX ix_readings_place ON readings (session_id, config, nest, id);
CREATE INDEX ix_readings_counted ON readings (session_id, kind, supersedes);
CREATE INDEX ix_ballbar_entries_kind ON ballbar_entries (session_id, kind, step_id);
CREATE INDEX ix_links_stream ON links (stream, id);
CREATE TRIGGER links_no_update BEFORE UPDATE ON links BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
CREATE TRIGGER links_no_delete BEFORE DELETE ON links BEGIN SELECT RAISE(ABORT, 'records are appended or superseded, never changed'); END;
DELETE FROM "sqlite_sequence";
INSERT INTO "sqlite_sequence" VALUES('models',0);
INSERT INTO "sqlite_sequence" VALUES('sessions',5);
INSERT INTO "sqlite_sequence" VALUES('links',203);
INSERT INTO "sqlite_sequence" VALUES('session_states',15);
INSERT INTO "sqlite_sequence" VALUES('events',114);
INSERT INTO "sqlite_sequence" VALUES('notes',12);
INSERT INTO "sqlite_sequence" VALUES('readings',43);
INSERT INTO "sqlite_sequence" VALUES('registrations',3);
INSERT INTO "sqlite_sequence" VALUES('skipped_stops',1);
INSERT INTO "sqlite_sequence" VALUES('added_stops',1);
INSERT INTO "sqlite_sequence" VALUES('ballbar_entries',7);
INSERT INTO "sqlite_sequence" VALUES('ballbar_answers',1);
COMMIT;
