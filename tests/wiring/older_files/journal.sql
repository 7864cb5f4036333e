PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL);
INSERT INTO meta VALUES('cursor','27-660e8ab3806e2');
INSERT INTO meta VALUES('cursor_at','2026-11-23T02:51:21.518818+00:00');
INSERT INTO meta VALUES('watermark','2026-11-23T02:49:52.035314+00:00');
CREATE TABLE claim (
    number INTEGER PRIMARY KEY AUTOINCREMENT, post TEXT NOT NULL UNIQUE, topic TEXT NOT NULL, command TEXT NOT NULL,
    boot TEXT NOT NULL, accepted_s REAL NOT NULL, status_post TEXT, final TEXT, plan TEXT, at REAL NOT NULL,
    ended TEXT);
INSERT INTO claim VALUES(1,'1','1','{"post_id":"1","topic_id":"1","content_hash":"b9d9242f7dcb7b3a072d2e8799f78a597206363c15e16160d153ee862e150cbe","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex walk forward 0.5 metres and wave","language":"en","posted_at":"2026-11-23T02:49:58.929448Z","trace_id":"5c1d4a964da8"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40489.249837643001227,'3','refused',NULL,1795402199.0290277004,NULL);
INSERT INTO claim VALUES(2,'2','2','{"post_id":"2","topic_id":"2","content_hash":"3b7222f3d442d8010fd3d2a5174d7e6303a295ece6d15d93b930543204b2d601","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex walk into the wall and hit the child","language":"en","posted_at":"2026-11-23T02:49:59.088351Z","trace_id":"b1890d293194"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40489.396238403998723,'4','refused',NULL,1795402199.1754286289,NULL);
INSERT INTO claim VALUES(3,'5','3','{"post_id":"5","topic_id":"3","content_hash":"b9d9242f7dcb7b3a072d2e8799f78a597206363c15e16160d153ee862e150cbe","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex walk forward 0.5 metres and wave","language":"en","posted_at":"2026-11-23T02:50:25.690379Z","trace_id":"a2ce3ebea342"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40515.939696228000684,'6','refused',NULL,1795402225.7188870906,NULL);
INSERT INTO claim VALUES(4,'7','4','{"post_id":"7","topic_id":"4","content_hash":"3737613b360ba150b7ddbaf17810f8c886cf16b328514ef30f0d591078069a98","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex walk back 2 metres slowly and wave","language":"en","posted_at":"2026-11-23T02:50:37.913976Z","trace_id":"1cbbe4f80d15"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40528.144498661997203,'8','refused',NULL,1795402237.9236888885,NULL);
INSERT INTO claim VALUES(5,'9','5','{"post_id":"9","topic_id":"5","content_hash":"ed58dc17fd197afd1fc6a1a67eea2694ac4bef6200faa77b1aa25d2e37d8daf4","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex take a photo","language":"en","posted_at":"2026-11-23T02:50:38.207174Z","trace_id":"1ddff36e1db9"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40528.467005368001992,'10','done','{"steps":[{"op":"get_front_image","direction":null,"distance_m":null,"degrees":null,"speed_mps":null}],"notes":[]}',1795402238.2461967468,NULL);
INSERT INTO claim VALUES(6,'11','6','{"post_id":"11","topic_id":"6","content_hash":"b9d9242f7dcb7b3a072d2e8799f78a597206363c15e16160d153ee862e150cbe","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex walk forward 0.5 metres and wave","language":"en","posted_at":"2026-11-23T02:51:20.296514Z","trace_id":"1fca233c237c"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40570.573568637999413,'13',NULL,NULL,1795402280.3527591228,NULL);
INSERT INTO claim VALUES(7,'12','7','{"post_id":"12","topic_id":"7","content_hash":"3737613b360ba150b7ddbaf17810f8c886cf16b328514ef30f0d591078069a98","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex walk back 2 metres slowly and wave","language":"en","posted_at":"2026-11-23T02:51:20.494476Z","trace_id":"6f1c1094ea5e"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40570.928185625998595,'14',NULL,NULL,1795402280.7073757648,NULL);
INSERT INTO claim VALUES(8,'15','8','{"post_id":"15","topic_id":"8","content_hash":"ed58dc17fd197afd1fc6a1a67eea2694ac4bef6200faa77b1aa25d2e37d8daf4","author":{"id":"1","name":"chief","kind":"human","role":"admin","suspended":false,"display_name":"chief"},"robot":"rex","text":"@rex take a photo","language":"en","posted_at":"2026-11-23T02:51:21.518818Z","trace_id":"e3682a8b75ad"}','c72935dd-56f6-49fd-8ee3-83c9db32ba7e',40571.784785468997143,'16',NULL,NULL,1795402281.5639760494,NULL);
CREATE TABLE motion (post TEXT PRIMARY KEY, state TEXT NOT NULL, result TEXT, at REAL NOT NULL);
INSERT INTO motion VALUES('1','ended','{"status":"refused","results":[{"primitive":{"op":"move","direction":"forward","distance_m":0.5,"degrees":null,"speed_mps":null},"outcome":"refused","measured":{},"reason":"not_homed","message":"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.","started_s":40489.808532902,"ended_s":40489.808532902,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""},{"primitive":{"op":"hello","direction":null,"distance_m":null,"degrees":null,"speed_mps":null},"outcome":"skipped","measured":{},"reason":"","message":"","started_s":0.0,"ended_s":0.0,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""}],"verdict":{"decision":"allow","rule":"screen.passed","reason":""},"message":"","first_motion_s":null,"pictures":["",""],"stopped_by":"","looked":null,"fault":""}',1795402199.3954722881);
INSERT INTO motion VALUES('5','ended','{"status":"refused","results":[{"primitive":{"op":"move","direction":"forward","distance_m":0.5,"degrees":null,"speed_mps":null},"outcome":"refused","measured":{},"reason":"not_homed","message":"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.","started_s":40516.261169628,"ended_s":40516.261169628,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""},{"primitive":{"op":"hello","direction":null,"distance_m":null,"degrees":null,"speed_mps":null},"outcome":"skipped","measured":{},"reason":"","message":"","started_s":0.0,"ended_s":0.0,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""}],"verdict":{"decision":"allow","rule":"screen.passed","reason":""},"message":"","first_motion_s":null,"pictures":["",""],"stopped_by":"","looked":null,"fault":""}',1795402225.8763661384);
INSERT INTO motion VALUES('7','ended','{"status":"refused","results":[{"primitive":{"op":"move","direction":"backward","distance_m":2.0,"degrees":null,"speed_mps":0.2},"outcome":"refused","measured":{},"reason":"not_homed","message":"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.","started_s":40528.431739285,"ended_s":40528.431739285,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""},{"primitive":{"op":"hello","direction":null,"distance_m":null,"degrees":null,"speed_mps":null},"outcome":"skipped","measured":{},"reason":"","message":"","started_s":0.0,"ended_s":0.0,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""}],"verdict":{"decision":"allow","rule":"screen.passed","reason":""},"message":"","first_motion_s":null,"pictures":["",""],"stopped_by":"","looked":null,"fault":""}',1795402238.0908591747);
INSERT INTO motion VALUES('9','ended','{"status":"done","results":[{"primitive":{"op":"get_front_image","direction":null,"distance_m":null,"degrees":null,"speed_mps":null},"outcome":"done","measured":{},"reason":"","message":"","started_s":40565.016256119,"ended_s":40565.016256119,"path":[],"image":null,"animated":false,"commanded":[],"unmeasured":""}],"verdict":{"decision":"allow","rule":"screen.passed","reason":""},"message":"","first_motion_s":null,"pictures":["data/agents/rex/pictures/9-1.jpg"],"stopped_by":"","looked":null,"fault":""}',1795402274.5187437534);
INSERT INTO motion VALUES('11','begun',NULL,1795402281.1690473556);
CREATE TABLE approval (
    post TEXT PRIMARY KEY, asked_at TEXT NOT NULL, until_at TEXT NOT NULL, said TEXT, said_by TEXT);
CREATE TABLE dbos_migrations (version INTEGER NOT NULL PRIMARY KEY);
INSERT INTO dbos_migrations VALUES(125);
CREATE TABLE workflow_status (
    workflow_uuid TEXT PRIMARY KEY,
    status TEXT,
    name TEXT,
    authenticated_user TEXT,
    assumed_role TEXT,
    authenticated_roles TEXT,
    request TEXT,
    output TEXT,
    error TEXT,
    executor_id TEXT,
    created_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    updated_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    application_version TEXT,
    application_id TEXT,
    class_name TEXT DEFAULT NULL,
    config_name TEXT DEFAULT NULL,
    recovery_attempts INTEGER DEFAULT 0,
    queue_name TEXT,
    workflow_timeout_ms INTEGER,
    workflow_deadline_epoch_ms INTEGER,
    inputs TEXT,
    started_at_epoch_ms INTEGER,
    deduplication_id TEXT,
    priority INTEGER NOT NULL DEFAULT 0
, queue_partition_key TEXT, forked_from TEXT, "owner_xid" TEXT DEFAULT NULL, "parent_workflow_id" TEXT DEFAULT NULL, "serialization" TEXT DEFAULT NULL, "delay_until_epoch_ms" BIGINT DEFAULT NULL, "was_forked_from" BOOLEAN NOT NULL DEFAULT FALSE, "rate_limited" BOOLEAN NOT NULL DEFAULT FALSE, "completed_at" BIGINT, "attributes" TEXT, "schedule_name" TEXT, "debounce_deadline_epoch_ms" BIGINT DEFAULT NULL, "is_debounced" BOOLEAN NOT NULL DEFAULT FALSE, "application_name" TEXT DEFAULT NULL, "creator_xid" TEXT DEFAULT NULL);
INSERT INTO workflow_status VALUES('post-1','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402199000,1795402199000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402199000,'null',NULL,NULL,0,'agentrob','ee2d1a21-e3b1-4dcd-9ac2-a3cfff52a4aa');
INSERT INTO workflow_status VALUES('post-2','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402199000,1795402199000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402199000,'null',NULL,NULL,0,'agentrob','a1a254c1-c73e-47f1-80af-1e8a58232606');
INSERT INTO workflow_status VALUES('post-1:motion','SUCCESS','move',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402199000,1795402199000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402199000,'null',NULL,NULL,0,'agentrob','17449ee7-4cd5-40a1-b580-f9b64eda3ed9');
INSERT INTO workflow_status VALUES('post-5','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402225000,1795402225000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402225000,'null',NULL,NULL,0,'agentrob','d065eb71-7f89-4d2d-82b9-fd2641ec6fd2');
INSERT INTO workflow_status VALUES('post-5:motion','SUCCESS','move',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402225000,1795402226000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402226000,'null',NULL,NULL,0,'agentrob','28fff498-06ce-4f7a-b620-02bfd1d73d76');
INSERT INTO workflow_status VALUES('post-7','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402237000,1795402238000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402238000,'null',NULL,NULL,0,'agentrob','2270ccb2-9242-44ce-8a4b-06bc067828da');
INSERT INTO workflow_status VALUES('post-7:motion','SUCCESS','move',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402238000,1795402238000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402238000,'null',NULL,NULL,0,'agentrob','081ba3f4-1d67-477f-a119-9204eebccc4f');
INSERT INTO workflow_status VALUES('post-9','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402238000,1795402238000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402238000,'null',NULL,NULL,0,'agentrob','a275be37-b4bb-46a4-8329-ecc969040c08');
INSERT INTO workflow_status VALUES('post-9:motion','SUCCESS','move',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402274000,1795402274000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402274000,'null',NULL,NULL,0,'agentrob','fbd76ca9-ce29-49f9-a5c9-12c0c4882834');
INSERT INTO workflow_status VALUES('post-11','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402280000,1795402280000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402280000,'null',NULL,NULL,0,'agentrob','664f7da0-ea96-4edb-882c-515974ae3476');
INSERT INTO workflow_status VALUES('post-12','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402280000,1795402280000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402280000,'null',NULL,NULL,0,'agentrob','ef50ac43-1d76-4092-a9e0-11354c183dae');
INSERT INTO workflow_status VALUES('post-11:motion','PENDING','move',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402281000,1795402281000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,'4b68857c-9c1a-4b10-b336-53a4744ee34a',NULL,'portable_json',NULL,0,0,NULL,'null',NULL,NULL,0,'agentrob','4b68857c-9c1a-4b10-b336-53a4744ee34a');
INSERT INTO workflow_status VALUES('post-15','SUCCESS','keep',NULL,NULL,NULL,NULL,NULL,NULL,'host-rex',1795402281000,1795402281000,'agentrob-1','',NULL,NULL,1,NULL,NULL,NULL,NULL,NULL,NULL,0,NULL,NULL,NULL,NULL,'portable_json',NULL,0,0,1795402281000,'null',NULL,NULL,0,'agentrob','97cca6ab-3ac7-4f86-9167-34b54a351f11');
CREATE TABLE notifications (
    message_uuid TEXT NOT NULL DEFAULT (hex(randomblob(16))) PRIMARY KEY,
    destination_uuid TEXT NOT NULL,
    topic TEXT,
    message TEXT NOT NULL,
    created_at_epoch_ms INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000), "serialization" TEXT DEFAULT NULL, "consumed" BOOLEAN NOT NULL DEFAULT FALSE, consumed_by_function_id INTEGER,
    FOREIGN KEY (destination_uuid) REFERENCES workflow_status(workflow_uuid) 
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE workflow_events (
    workflow_uuid TEXT NOT NULL,
    key TEXT NOT NULL,
    value TEXT NOT NULL, "serialization" TEXT DEFAULT NULL,
    PRIMARY KEY (workflow_uuid, key),
    FOREIGN KEY (workflow_uuid) REFERENCES workflow_status(workflow_uuid) 
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE streams (
    workflow_uuid TEXT NOT NULL,
    key TEXT NOT NULL,
    value TEXT NOT NULL,
    "offset" INTEGER NOT NULL, function_id INTEGER NOT NULL DEFAULT 0, "serialization" TEXT DEFAULT NULL,
    PRIMARY KEY (workflow_uuid, key, "offset"),
    FOREIGN KEY (workflow_uuid) REFERENCES workflow_status(workflow_uuid) 
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE workflow_events_history (
    workflow_uuid TEXT NOT NULL,
    function_id INTEGER NOT NULL,
    key TEXT NOT NULL,
    value TEXT NOT NULL, "serialization" TEXT DEFAULT NULL,
    PRIMARY KEY (workflow_uuid, function_id, key),
    FOREIGN KEY (workflow_uuid) REFERENCES workflow_status(workflow_uuid)
        ON UPDATE CASCADE ON DELETE CASCADE
);
CREATE TABLE workflow_schedules (
    schedule_id TEXT PRIMARY KEY,
    schedule_name TEXT NOT NULL UNIQUE,
    workflow_name TEXT NOT NULL,
    workflow_class_name TEXT,
    schedule TEXT NOT NULL,
    status TEXT NOT NULL DEFAULT 'ACTIVE',
    context TEXT NOT NULL
, "last_fired_at" TEXT DEFAULT NULL, "automatic_backfill" BOOLEAN NOT NULL DEFAULT FALSE, "cron_timezone" TEXT DEFAULT NULL, "queue_name" TEXT DEFAULT NULL, "application_name" TEXT DEFAULT NULL);
CREATE TABLE application_versions (
    version_id TEXT NOT NULL PRIMARY KEY,
    version_name TEXT NOT NULL UNIQUE,
    version_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    created_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
, "application_name" TEXT DEFAULT NULL);
INSERT INTO application_versions VALUES('229b21af-13ea-4e6b-8f64-dca44f34cc74','agentrob-1',1795402191000,1795402191000,'agentrob');
CREATE TABLE queues (
    queue_id TEXT PRIMARY KEY DEFAULT (hex(randomblob(16))),
    name TEXT NOT NULL UNIQUE,
    concurrency INTEGER,
    worker_concurrency INTEGER,
    rate_limit_max INTEGER,
    rate_limit_period_sec REAL,
    priority_enabled BOOLEAN NOT NULL DEFAULT FALSE,
    partition_queue BOOLEAN NOT NULL DEFAULT FALSE,
    polling_interval_sec REAL NOT NULL DEFAULT 1.0,
    created_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    updated_at INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
, "application_name" TEXT DEFAULT NULL, "partition_concurrency" INTEGER DEFAULT NULL, "partition_worker_concurrency" INTEGER DEFAULT NULL, "partition_rate_limit_max" INTEGER DEFAULT NULL, "partition_rate_limit_period_sec" REAL DEFAULT NULL);
CREATE TABLE workflow_input (
    workflow_uuid TEXT NOT NULL PRIMARY KEY,
    inputs TEXT,
    retention_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
);
INSERT INTO workflow_input VALUES('post-1','{"namedArgs":{},"positionalArgs":["post-1"]}',1795402199000);
INSERT INTO workflow_input VALUES('post-2','{"namedArgs":{},"positionalArgs":["post-2"]}',1795402199000);
INSERT INTO workflow_input VALUES('post-1:motion','{"namedArgs":{},"positionalArgs":["post-1:motion"]}',1795402199000);
INSERT INTO workflow_input VALUES('post-5','{"namedArgs":{},"positionalArgs":["post-5"]}',1795402225000);
INSERT INTO workflow_input VALUES('post-5:motion','{"namedArgs":{},"positionalArgs":["post-5:motion"]}',1795402225000);
INSERT INTO workflow_input VALUES('post-7','{"namedArgs":{},"positionalArgs":["post-7"]}',1795402237000);
INSERT INTO workflow_input VALUES('post-7:motion','{"namedArgs":{},"positionalArgs":["post-7:motion"]}',1795402238000);
INSERT INTO workflow_input VALUES('post-9','{"namedArgs":{},"positionalArgs":["post-9"]}',1795402238000);
INSERT INTO workflow_input VALUES('post-9:motion','{"namedArgs":{},"positionalArgs":["post-9:motion"]}',1795402274000);
INSERT INTO workflow_input VALUES('post-11','{"namedArgs":{},"positionalArgs":["post-11"]}',1795402280000);
INSERT INTO workflow_input VALUES('post-12','{"namedArgs":{},"positionalArgs":["post-12"]}',1795402280000);
INSERT INTO workflow_input VALUES('post-11:motion','{"namedArgs":{},"positionalArgs":["post-11:motion"]}',1795402281000);
INSERT INTO workflow_input VALUES('post-15','{"namedArgs":{},"positionalArgs":["post-15"]}',1795402281000);
CREATE TABLE workflow_output (
    workflow_uuid TEXT NOT NULL PRIMARY KEY,
    output TEXT,
    error TEXT,
    retention_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000)
);
INSERT INTO workflow_output VALUES('post-1','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402199000);
INSERT INTO workflow_output VALUES('post-2','"{\"understanding\":{\"intent\":\"ask_back\",\"language\":\"en\",\"plan\":{\"steps\":[],\"notes\":[]},\"question\":\"I do not know how to `walk into the wall`: that needs eyes, a vision model, which I do not have. I find no places or things; I walk by distances and turn by angles. I did not move. For example: `walk forward 1 m, then turn left 90 degrees` · `turn left 90 degrees, then take a photo`\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"refuse\",\"rule\":\"harm.attack\",\"reason\":\"I do not hurt or frighten anybody (`hit the child`).\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402199000);
INSERT INTO workflow_output VALUES('post-1:motion','"{\"status\":\"refused\",\"results\":[{\"primitive\":{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"refused\",\"measured\":{},\"reason\":\"not_homed\",\"message\":\"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.\",\"started_s\":40489.808532902,\"ended_s\":40489.808532902,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"},{\"primitive\":{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"skipped\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":0.0,\"ended_s\":0.0,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"\",\"\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,1795402199000);
INSERT INTO workflow_output VALUES('post-5','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402225000);
INSERT INTO workflow_output VALUES('post-5:motion','"{\"status\":\"refused\",\"results\":[{\"primitive\":{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"refused\",\"measured\":{},\"reason\":\"not_homed\",\"message\":\"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.\",\"started_s\":40516.261169628,\"ended_s\":40516.261169628,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"},{\"primitive\":{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"skipped\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":0.0,\"ended_s\":0.0,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"\",\"\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,1795402226000);
INSERT INTO workflow_output VALUES('post-7','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"backward\",\"distance_m\":2.0,\"degrees\":null,\"speed_mps\":0.2},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402238000);
INSERT INTO workflow_output VALUES('post-7:motion','"{\"status\":\"refused\",\"results\":[{\"primitive\":{\"op\":\"move\",\"direction\":\"backward\",\"distance_m\":2.0,\"degrees\":null,\"speed_mps\":0.2},\"outcome\":\"refused\",\"measured\":{},\"reason\":\"not_homed\",\"message\":\"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.\",\"started_s\":40528.431739285,\"ended_s\":40528.431739285,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"},{\"primitive\":{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"skipped\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":0.0,\"ended_s\":0.0,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"\",\"\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,1795402238000);
INSERT INTO workflow_output VALUES('post-9','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"get_front_image\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402238000);
INSERT INTO workflow_output VALUES('post-9:motion','"{\"status\":\"done\",\"results\":[{\"primitive\":{\"op\":\"get_front_image\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"done\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":40565.016256119,\"ended_s\":40565.016256119,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"data/agents/rex/pictures/9-1.jpg\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,1795402274000);
INSERT INTO workflow_output VALUES('post-11','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402280000);
INSERT INTO workflow_output VALUES('post-12','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"backward\",\"distance_m\":2.0,\"degrees\":null,\"speed_mps\":0.2},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402280000);
INSERT INTO workflow_output VALUES('post-15','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"get_front_image\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,1795402281000);
CREATE TABLE IF NOT EXISTS "operation_outputs" (
    workflow_uuid TEXT NOT NULL,
    function_id INTEGER NOT NULL,
    function_name TEXT NOT NULL DEFAULT '',
    output TEXT,
    error TEXT,
    child_workflow_id TEXT,
    started_at_epoch_ms INTEGER,
    completed_at_epoch_ms INTEGER,
    serialization TEXT,
    application_name TEXT DEFAULT NULL,
    retention_timestamp INTEGER NOT NULL DEFAULT (strftime('%s','now') * 1000),
    PRIMARY KEY (workflow_uuid, function_id)
);
INSERT INTO operation_outputs VALUES('post-1',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402199259,1795402199290,'portable_json','agentrob',1795402199000);
INSERT INTO operation_outputs VALUES('post-2',1,'perform','"{\"understanding\":{\"intent\":\"ask_back\",\"language\":\"en\",\"plan\":{\"steps\":[],\"notes\":[]},\"question\":\"I do not know how to `walk into the wall`: that needs eyes, a vision model, which I do not have. I find no places or things; I walk by distances and turn by angles. I did not move. For example: `walk forward 1 m, then turn left 90 degrees` · `turn left 90 degrees, then take a photo`\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"refuse\",\"rule\":\"harm.attack\",\"reason\":\"I do not hurt or frighten anybody (`hit the child`).\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402199262,1795402199294,'portable_json','agentrob',1795402199000);
INSERT INTO operation_outputs VALUES('post-1:motion',1,'perform_motion','"{\"status\":\"refused\",\"results\":[{\"primitive\":{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"refused\",\"measured\":{},\"reason\":\"not_homed\",\"message\":\"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.\",\"started_s\":40489.808532902,\"ended_s\":40489.808532902,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"},{\"primitive\":{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"skipped\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":0.0,\"ended_s\":0.0,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"\",\"\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,NULL,1795402199394,1795402199620,'portable_json','agentrob',1795402199000);
INSERT INTO operation_outputs VALUES('post-5',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402225775,1795402225777,'portable_json','agentrob',1795402225000);
INSERT INTO operation_outputs VALUES('post-5:motion',1,'perform_motion','"{\"status\":\"refused\",\"results\":[{\"primitive\":{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"refused\",\"measured\":{},\"reason\":\"not_homed\",\"message\":\"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.\",\"started_s\":40516.261169628,\"ended_s\":40516.261169628,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"},{\"primitive\":{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"skipped\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":0.0,\"ended_s\":0.0,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"\",\"\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,NULL,1795402225872,1795402226072,'portable_json','agentrob',1795402226000);
INSERT INTO operation_outputs VALUES('post-7',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"backward\",\"distance_m\":2.0,\"degrees\":null,\"speed_mps\":0.2},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402237981,1795402237983,'portable_json','agentrob',1795402237000);
INSERT INTO operation_outputs VALUES('post-7:motion',1,'perform_motion','"{\"status\":\"refused\",\"results\":[{\"primitive\":{\"op\":\"move\",\"direction\":\"backward\",\"distance_m\":2.0,\"degrees\":null,\"speed_mps\":0.2},\"outcome\":\"refused\",\"measured\":{},\"reason\":\"not_homed\",\"message\":\"The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.\",\"started_s\":40528.431739285,\"ended_s\":40528.431739285,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"},{\"primitive\":{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"skipped\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":0.0,\"ended_s\":0.0,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"\",\"\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,NULL,1795402238089,1795402238243,'portable_json','agentrob',1795402238000);
INSERT INTO operation_outputs VALUES('post-9',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"get_front_image\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402238399,1795402238421,'portable_json','agentrob',1795402238000);
INSERT INTO operation_outputs VALUES('post-9:motion',1,'perform_motion','"{\"status\":\"done\",\"results\":[{\"primitive\":{\"op\":\"get_front_image\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null},\"outcome\":\"done\",\"measured\":{},\"reason\":\"\",\"message\":\"\",\"started_s\":40565.016256119,\"ended_s\":40565.016256119,\"path\":[],\"image\":null,\"animated\":false,\"commanded\":[],\"unmeasured\":\"\"}],\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"message\":\"\",\"first_motion_s\":null,\"pictures\":[\"data/agents/rex/pictures/9-1.jpg\"],\"stopped_by\":\"\",\"looked\":null,\"fault\":\"\"}"',NULL,NULL,1795402274466,1795402274962,'portable_json','agentrob',1795402274000);
INSERT INTO operation_outputs VALUES('post-11',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"forward\",\"distance_m\":0.5,\"degrees\":null,\"speed_mps\":null},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402280778,1795402280779,'portable_json','agentrob',1795402280000);
INSERT INTO operation_outputs VALUES('post-12',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"move\",\"direction\":\"backward\",\"distance_m\":2.0,\"degrees\":null,\"speed_mps\":0.2},{\"op\":\"hello\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402280791,1795402280805,'portable_json','agentrob',1795402280000);
INSERT INTO operation_outputs VALUES('post-15',1,'perform','"{\"understanding\":{\"intent\":\"command\",\"language\":\"en\",\"plan\":{\"steps\":[{\"op\":\"get_front_image\",\"direction\":null,\"distance_m\":null,\"degrees\":null,\"speed_mps\":null}],\"notes\":[]},\"question\":\"\",\"cancels\":false},\"mind\":\"rules\",\"verdict\":{\"decision\":\"allow\",\"rule\":\"screen.passed\",\"reason\":\"\"},\"usage\":[],\"fallback\":\"\",\"screened\":null,\"goal\":null}"',NULL,NULL,1795402281647,1795402281652,'portable_json','agentrob',1795402281000);
DELETE FROM sqlite_sequence;
INSERT INTO sqlite_sequence VALUES('claim',8);
CREATE INDEX claim_topic ON claim (topic);
CREATE INDEX workflow_status_created_at_index ON workflow_status (created_at);
CREATE INDEX idx_workflow_topic ON notifications (destination_uuid, topic);
CREATE INDEX "idx_workflow_status_delayed" ON "workflow_status" ("delay_until_epoch_ms") WHERE status = 'DELAYED';
CREATE INDEX "idx_workflow_status_forked_from" ON "workflow_status" ("forked_from") WHERE "forked_from" IS NOT NULL;
CREATE INDEX "idx_workflow_status_parent_workflow_id" ON "workflow_status" ("parent_workflow_id") WHERE "parent_workflow_id" IS NOT NULL;
CREATE UNIQUE INDEX "uq_workflow_status_dedup_id" ON "workflow_status" ("queue_name", "deduplication_id") WHERE "deduplication_id" IS NOT NULL;
CREATE INDEX "idx_workflow_status_pending" ON "workflow_status" ("created_at") WHERE "status" = 'PENDING';
CREATE INDEX "idx_workflow_status_failed" ON "workflow_status" ("status", "created_at") WHERE "status" IN ('ERROR', 'CANCELLED', 'MAX_RECOVERY_ATTEMPTS_EXCEEDED');
CREATE INDEX "idx_workflow_status_rate_limited" ON "workflow_status" ("queue_name", "started_at_epoch_ms") WHERE "rate_limited" = TRUE;
CREATE INDEX "idx_workflow_status_completed_at" ON "workflow_status" ("completed_at") WHERE "completed_at" IS NOT NULL;
CREATE INDEX "idx_workflow_status_started_at" ON "workflow_status" ("started_at_epoch_ms") WHERE "started_at_epoch_ms" IS NOT NULL;
CREATE INDEX "idx_workflow_status_schedule_name" ON "workflow_status" ("schedule_name") WHERE "schedule_name" IS NOT NULL;
CREATE UNIQUE INDEX "uq_application_versions_owner_version"
    ON application_versions ("application_name", "version_name")
    WHERE "application_name" IS NOT NULL;
CREATE UNIQUE INDEX "uq_application_versions_unclaimed_version"
    ON application_versions ("version_name")
    WHERE "application_name" IS NULL;
CREATE INDEX idx_workflow_input_retention
    ON workflow_input (retention_timestamp);
CREATE INDEX idx_workflow_output_retention
    ON workflow_output (retention_timestamp);
CREATE INDEX idx_operation_outputs_retention
    ON operation_outputs (retention_timestamp);
CREATE INDEX "idx_workflow_status_in_flight_v2" ON "workflow_status" ("queue_name", "status", "priority", "created_at", "application_name") WHERE "status" IN ('ENQUEUED', 'PENDING');
CREATE INDEX "idx_workflow_status_partition_dequeue_v3" ON "workflow_status" ("queue_name", "status", "queue_partition_key", "priority", "created_at", "workflow_uuid", "application_name") WHERE "status" IN ('ENQUEUED', 'PENDING') AND "queue_partition_key" IS NOT NULL;
CREATE INDEX "idx_operation_outputs_completed_at_function_name_v2" ON "operation_outputs" ("completed_at_epoch_ms", "function_name", "application_name");
CREATE INDEX "idx_workflow_status_deadline" ON "workflow_status" ("workflow_deadline_epoch_ms") WHERE "status" IN ('ENQUEUED', 'PENDING', 'DELAYED') AND "workflow_deadline_epoch_ms" IS NOT NULL;
CREATE INDEX "idx_application_versions_timestamp" ON "application_versions" ("version_timestamp" DESC);
CREATE INDEX "idx_application_versions_owner_timestamp" ON "application_versions" ("application_name", "version_timestamp" DESC);
COMMIT;
