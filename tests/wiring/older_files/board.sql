PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
CREATE TABLE alembic_version (
	version_num VARCHAR(32) NOT NULL, 
	CONSTRAINT alembic_version_pkc PRIMARY KEY (version_num)
);
INSERT INTO alembic_version VALUES('0006_tags');
CREATE TABLE accounts (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	name VARCHAR(32) NOT NULL, 
	display_name VARCHAR(64) NOT NULL, 
	kind VARCHAR(20) NOT NULL, 
	role VARCHAR(10) NOT NULL, 
	suspended BOOLEAN NOT NULL, 
	password_hash VARCHAR(200), 
	created_us BIGINT NOT NULL, read_up_to INTEGER DEFAULT '0' NOT NULL, 
	CONSTRAINT uq_accounts_name UNIQUE (name)
);
INSERT INTO accounts VALUES(1,'chief','','human','admin',0,NULL,1795402137936874,0);
INSERT INTO accounts VALUES(2,'rex','','robot_agent','member',0,NULL,1795402153302119,0);
INSERT INTO accounts VALUES(3,'ann','','human','member',0,NULL,1795402176487139,0);
CREATE TABLE tokens (
	hash VARCHAR(64) NOT NULL, 
	account_id INTEGER NOT NULL, 
	label VARCHAR(64) NOT NULL, 
	created_us BIGINT NOT NULL, 
	revoked_us BIGINT, scopes VARCHAR(40) DEFAULT 'read write' NOT NULL, 
	CONSTRAINT pk_tokens PRIMARY KEY (hash), 
	CONSTRAINT fk_tokens_account_id FOREIGN KEY(account_id) REFERENCES accounts (id)
);
INSERT INTO tokens VALUES('c7ed0e613cdd34a81f98dc337cbfb5baeab85c14bcca3a5bccbb1ee1e15e1a19',2,'',1795402153462799,NULL,'read write');
INSERT INTO tokens VALUES('1c897d11bef26975c994767277e719225e7ec94a14efc90b1bbe5c83c1e65faf',1,'',1795402198246281,NULL,'read write');
CREATE TABLE sessions (
	hash VARCHAR(64) NOT NULL, 
	account_id INTEGER NOT NULL, 
	created_us BIGINT NOT NULL, 
	expires_us BIGINT NOT NULL, 
	CONSTRAINT pk_sessions PRIMARY KEY (hash), 
	CONSTRAINT fk_sessions_account_id FOREIGN KEY(account_id) REFERENCES accounts (id)
);
CREATE TABLE links (
	hash VARCHAR(64) NOT NULL, 
	account_id INTEGER NOT NULL, 
	expires_us BIGINT NOT NULL, 
	used_us BIGINT, purpose VARCHAR(10) DEFAULT 'enter' NOT NULL, 
	CONSTRAINT pk_links PRIMARY KEY (hash), 
	CONSTRAINT fk_links_account_id FOREIGN KEY(account_id) REFERENCES accounts (id)
);
INSERT INTO links VALUES('4a0fafe2e571d513136b793ac5a93c3174590cb5e6b28071d17123c554c75270',1,1795488537946931,NULL,'password');
INSERT INTO links VALUES('32ac1d50533a1348890ba214fe9e49b06988c157587273972c421911bec375c2',3,1795402776554093,NULL,'enter');
CREATE TABLE boards (
	id VARCHAR(32) NOT NULL, 
	name VARCHAR(64) NOT NULL, 
	description VARCHAR(200) NOT NULL, 
	position INTEGER NOT NULL, read_role VARCHAR(10) DEFAULT 'guest' NOT NULL, post_role VARCHAR(10) DEFAULT 'member' NOT NULL, command_role VARCHAR(10) DEFAULT 'operator' NOT NULL, 
	CONSTRAINT pk_boards PRIMARY KEY (id)
);
INSERT INTO boards VALUES('robots','Robots','Ask a robot to do something: mention it by name.',0,'guest','member','operator');
INSERT INTO boards VALUES('talk','Talk','Everything else. No robot acts here.',1,'guest','member','operator');
CREATE TABLE topics (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	board_id VARCHAR(32) NOT NULL, 
	title VARCHAR(200) NOT NULL, 
	author_id INTEGER NOT NULL, 
	created_us BIGINT NOT NULL, 
	last_post_id INTEGER NOT NULL, 
	last_post_us BIGINT NOT NULL, 
	posts INTEGER NOT NULL, locked BOOLEAN DEFAULT 0 NOT NULL, 
	CONSTRAINT fk_topics_author_id FOREIGN KEY(author_id) REFERENCES accounts (id), 
	CONSTRAINT fk_topics_board_id FOREIGN KEY(board_id) REFERENCES boards (id)
);
INSERT INTO topics VALUES(1,'robots','A first walk',1,1795402198929448,3,1795402199333081,2,0);
INSERT INTO topics VALUES(2,'robots','Refused',1,1795402199088351,4,1795402199354570,2,0);
INSERT INTO topics VALUES(3,'robots','A walk',1,1795402225690379,6,1795402225810775,2,0);
INSERT INTO topics VALUES(4,'robots','Cut short',1,1795402237913976,8,1795402238048484,2,0);
INSERT INTO topics VALUES(5,'robots','Waits',1,1795402238207174,10,1795402238496128,2,0);
INSERT INTO topics VALUES(6,'robots','A walk',1,1795402280296514,13,1795402280966979,2,0);
INSERT INTO topics VALUES(7,'robots','Cut short',1,1795402280494476,14,1795402281051795,2,0);
INSERT INTO topics VALUES(8,'robots','Waits',1,1795402281518818,16,1795402281714050,2,0);
CREATE TABLE posts (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	topic_id INTEGER NOT NULL, 
	author_id INTEGER NOT NULL, 
	raw TEXT NOT NULL, 
	html TEXT NOT NULL, 
	version INTEGER NOT NULL, 
	created_us BIGINT NOT NULL, 
	edited_us BIGINT, 
	removed BOOLEAN NOT NULL, 
	removed_by INTEGER, 
	mentions JSON NOT NULL, 
	reply_to INTEGER, 
	"key" VARCHAR(200), 
	card JSON, 
	CONSTRAINT fk_posts_author_id FOREIGN KEY(author_id) REFERENCES accounts (id), 
	CONSTRAINT fk_posts_removed_by FOREIGN KEY(removed_by) REFERENCES accounts (id), 
	CONSTRAINT fk_posts_reply_to FOREIGN KEY(reply_to) REFERENCES posts (id), 
	CONSTRAINT fk_posts_topic_id FOREIGN KEY(topic_id) REFERENCES topics (id), 
	CONSTRAINT uq_posts_author_id_key UNIQUE (author_id, "key")
);
INSERT INTO posts VALUES(1,1,1,'@rex walk forward 0.5 metres and wave',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> walk forward 0.5 metres and wave</p>\n','\n',char(10)),1,1795402198929448,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(2,2,1,'@rex walk into the wall and hit the child',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> walk into the wall and hit the child</p>\n','\n',char(10)),1,1795402199088351,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(3,1,2,replace('**Refused.**\n\nThe robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: `guard.not_homed`.\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | walk forward 0.5 m | – | refused |\n| 2 | wave | – | not begun |\n\nMy owner (`chief`) or an admin sets my home, where I stand, with the button Set home here on [my page](http://127.0.0.1:8199/robots/rex), or with `agentrob home rex` on my machine.\n\n*seen after 0.45 s · [trace `5c1d4a964da8`](http://127.0.0.1:8199/c/1)*','\n',char(10)),replace('<p><strong>Refused.</strong></p>\n<p>The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: <code>guard.not_homed</code>.</p>\n<table>\n<thead>\n<tr>\n<th align="right">Step</th>\n<th>Asked</th>\n<th>Measured</th>\n<th>Outcome</th>\n</tr>\n</thead>\n<tbody>\n<tr>\n<td align="right">1</td>\n<td>walk forward 0.5 m</td>\n<td>–</td>\n<td>refused</td>\n</tr>\n<tr>\n<td align="right">2</td>\n<td>wave</td>\n<td>–</td>\n<td>not begun</td>\n</tr>\n</tbody>\n</table>\n<p>My owner (<code>chief</code>) or an admin sets my home, where I stand, with the button Set home here on <a href="http://127.0.0.1:8199/robots/rex" rel="nofollow noopener ugc">my page</a>, or with <code>agentrob home rex</code> on my machine.</p>\n<p><em>seen after 0.45 s · <a href="http://127.0.0.1:8199/c/1" rel="nofollow noopener ugc">trace <code>5c1d4a964da8</code></a></em></p>\n','\n',char(10)),3,1795402199333081,1795402202120377,0,NULL,'[]',1,'claim:1','{"robot": "rex", "state": "refused", "step": 2, "steps": 2, "doing": "", "place": null, "trace_id": "5c1d4a964da8", "until": ""}');
INSERT INTO posts VALUES(4,2,2,replace('**Refused.**\n\nI do not hurt or frighten anybody (`hit the child`). Rule: `harm.attack`.\n\n*seen after 0.33 s · [trace `b1890d293194`](http://127.0.0.1:8199/c/2)*','\n',char(10)),replace('<p><strong>Refused.</strong></p>\n<p>I do not hurt or frighten anybody (<code>hit the child</code>). Rule: <code>harm.attack</code>.</p>\n<p><em>seen after 0.33 s · <a href="http://127.0.0.1:8199/c/2" rel="nofollow noopener ugc">trace <code>b1890d293194</code></a></em></p>\n','\n',char(10)),2,1795402199354570,1795402199609677,0,NULL,'[]',2,'claim:2','{"robot": "rex", "state": "refused", "step": 0, "steps": 0, "doing": "", "place": null, "trace_id": "b1890d293194", "until": ""}');
INSERT INTO posts VALUES(5,3,1,'@rex walk forward 0.5 metres and wave',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> walk forward 0.5 metres and wave</p>\n','\n',char(10)),1,1795402225690379,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(6,3,2,replace('**Refused.**\n\nThe robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: `guard.not_homed`.\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | walk forward 0.5 m | – | refused |\n| 2 | wave | – | not begun |\n\nMy owner (`chief`) or an admin sets my home, where I stand, with the button Set home here on [my page](http://127.0.0.1:8199/robots/rex), or with `agentrob home rex` on my machine.\n\n*seen after 0.15 s · [trace `a2ce3ebea342`](http://127.0.0.1:8199/c/5)*','\n',char(10)),replace('<p><strong>Refused.</strong></p>\n<p>The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: <code>guard.not_homed</code>.</p>\n<table>\n<thead>\n<tr>\n<th align="right">Step</th>\n<th>Asked</th>\n<th>Measured</th>\n<th>Outcome</th>\n</tr>\n</thead>\n<tbody>\n<tr>\n<td align="right">1</td>\n<td>walk forward 0.5 m</td>\n<td>–</td>\n<td>refused</td>\n</tr>\n<tr>\n<td align="right">2</td>\n<td>wave</td>\n<td>–</td>\n<td>not begun</td>\n</tr>\n</tbody>\n</table>\n<p>My owner (<code>chief</code>) or an admin sets my home, where I stand, with the button Set home here on <a href="http://127.0.0.1:8199/robots/rex" rel="nofollow noopener ugc">my page</a>, or with <code>agentrob home rex</code> on my machine.</p>\n<p><em>seen after 0.15 s · <a href="http://127.0.0.1:8199/c/5" rel="nofollow noopener ugc">trace <code>a2ce3ebea342</code></a></em></p>\n','\n',char(10)),3,1795402225810775,1795402226153964,0,NULL,'[]',5,'claim:5','{"robot": "rex", "state": "refused", "step": 2, "steps": 2, "doing": "", "place": null, "trace_id": "a2ce3ebea342", "until": ""}');
INSERT INTO posts VALUES(7,4,1,'@rex walk back 2 metres slowly and wave',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> walk back 2 metres slowly and wave</p>\n','\n',char(10)),1,1795402237913976,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(8,4,2,replace('**Refused.**\n\nThe robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: `guard.not_homed`.\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | walk backward 2 m at 0.2 m/s | – | refused |\n| 2 | wave | – | not begun |\n\nMy owner (`chief`) or an admin sets my home, where I stand, with the button Set home here on [my page](http://127.0.0.1:8199/robots/rex), or with `agentrob home rex` on my machine.\n\n*seen after 0.16 s · [trace `1cbbe4f80d15`](http://127.0.0.1:8199/c/7)*','\n',char(10)),replace('<p><strong>Refused.</strong></p>\n<p>The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: <code>guard.not_homed</code>.</p>\n<table>\n<thead>\n<tr>\n<th align="right">Step</th>\n<th>Asked</th>\n<th>Measured</th>\n<th>Outcome</th>\n</tr>\n</thead>\n<tbody>\n<tr>\n<td align="right">1</td>\n<td>walk backward 2 m at 0.2 m/s</td>\n<td>–</td>\n<td>refused</td>\n</tr>\n<tr>\n<td align="right">2</td>\n<td>wave</td>\n<td>–</td>\n<td>not begun</td>\n</tr>\n</tbody>\n</table>\n<p>My owner (<code>chief</code>) or an admin sets my home, where I stand, with the button Set home here on <a href="http://127.0.0.1:8199/robots/rex" rel="nofollow noopener ugc">my page</a>, or with <code>agentrob home rex</code> on my machine.</p>\n<p><em>seen after 0.16 s · <a href="http://127.0.0.1:8199/c/7" rel="nofollow noopener ugc">trace <code>1cbbe4f80d15</code></a></em></p>\n','\n',char(10)),3,1795402238048484,1795402238366672,0,NULL,'[]',7,'claim:7','{"robot": "rex", "state": "refused", "step": 2, "steps": 2, "doing": "", "place": null, "trace_id": "1cbbe4f80d15", "until": ""}');
INSERT INTO posts VALUES(9,5,1,'@rex take a photo',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> take a photo</p>\n','\n',char(10)),1,1795402238207174,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(10,5,2,replace('**Done.**\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | take a photo | – | done |\n\nPictures: photo of step 1.\n\n*seen after 36.21 s · done after 36.6 s · [trace `1ddff36e1db9`](http://127.0.0.1:8199/c/9)*','\n',char(10)),replace('<p><strong>Done.</strong></p>\n<table>\n<thead>\n<tr>\n<th align="right">Step</th>\n<th>Asked</th>\n<th>Measured</th>\n<th>Outcome</th>\n</tr>\n</thead>\n<tbody>\n<tr>\n<td align="right">1</td>\n<td>take a photo</td>\n<td>–</td>\n<td>done</td>\n</tr>\n</tbody>\n</table>\n<p>Pictures: photo of step 1.</p>\n<p><em>seen after 36.21 s · done after 36.6 s · <a href="http://127.0.0.1:8199/c/9" rel="nofollow noopener ugc">trace <code>1ddff36e1db9</code></a></em></p>\n','\n',char(10)),4,1795402238496128,1795402275168176,0,NULL,'[]',9,'claim:9','{"robot": "rex", "state": "done", "step": 1, "steps": 1, "doing": "", "place": null, "trace_id": "1ddff36e1db9", "until": ""}');
INSERT INTO posts VALUES(11,6,1,'@rex walk forward 0.5 metres and wave',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> walk forward 0.5 metres and wave</p>\n','\n',char(10)),1,1795402280296514,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(12,7,1,'@rex walk back 2 metres slowly and wave',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> walk back 2 metres slowly and wave</p>\n','\n',char(10)),1,1795402280494476,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(13,6,2,'Step 1 of 2: walk forward 0.5 m …',replace('<p>Step 1 of 2: walk forward 0.5 m …</p>\n','\n',char(10)),2,1795402280966979,1795402281434056,0,NULL,'[]',11,'claim:11','{"robot": "rex", "state": "running", "step": 1, "steps": 2, "doing": "walk forward 0.5 m", "place": null, "trace_id": "1fca233c237c", "until": ""}');
INSERT INTO posts VALUES(14,7,2,'Queued: the same account may command me again in 2 s, and then I go on by myself.',replace('<p>Queued: the same account may command me again in 2 s, and then I go on by myself.</p>\n','\n',char(10)),2,1795402281051795,1795402281203381,0,NULL,'[]',12,'claim:12','{"robot": "rex", "state": "queued", "step": 0, "steps": 0, "doing": "", "place": null, "trace_id": "6f1c1094ea5e", "until": ""}');
INSERT INTO posts VALUES(15,8,1,'@rex take a photo',replace('<p><a href="/u/rex" class="mention" rel="nofollow noopener ugc">@rex</a> take a photo</p>\n','\n',char(10)),1,1795402281518818,NULL,0,NULL,'["rex"]',NULL,NULL,NULL);
INSERT INTO posts VALUES(16,8,2,'Seen. *trace `e3682a8b75ad`*',replace('<p>Seen. <em>trace <code>e3682a8b75ad</code></em></p>\n','\n',char(10)),1,1795402281714050,NULL,0,NULL,'[]',15,'claim:15','{"robot": "rex", "state": "seen", "step": 0, "steps": 0, "doing": "", "place": null, "trace_id": "e3682a8b75ad", "until": ""}');
CREATE TABLE post_versions (
	post_id INTEGER NOT NULL, 
	version INTEGER NOT NULL, 
	raw TEXT NOT NULL, 
	until_us BIGINT NOT NULL, 
	CONSTRAINT pk_post_versions PRIMARY KEY (post_id, version), 
	CONSTRAINT fk_post_versions_post_id FOREIGN KEY(post_id) REFERENCES posts (id)
);
CREATE TABLE images (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	account_id INTEGER NOT NULL, 
	sha256 VARCHAR(64) NOT NULL, 
	media_type VARCHAR(20) NOT NULL, 
	width INTEGER NOT NULL, 
	height INTEGER NOT NULL, 
	created_us BIGINT NOT NULL, gone_us BIGINT, 
	CONSTRAINT fk_images_account_id FOREIGN KEY(account_id) REFERENCES accounts (id)
);
INSERT INTO images VALUES(1,2,'a3ebb4401a18577267cbd644c6a927d3b74fc137b87ce53a03c9a77bd2fe751d','image/jpeg',320,240,1795402275148589,NULL);
CREATE TABLE post_images (
	post_id INTEGER NOT NULL, 
	position INTEGER NOT NULL, 
	image_id INTEGER NOT NULL, 
	CONSTRAINT pk_post_images PRIMARY KEY (post_id, position), 
	CONSTRAINT fk_post_images_image_id FOREIGN KEY(image_id) REFERENCES images (id), 
	CONSTRAINT fk_post_images_post_id FOREIGN KEY(post_id) REFERENCES posts (id)
);
INSERT INTO post_images VALUES(10,0,1);
CREATE TABLE events (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	kind VARCHAR(20) NOT NULL, 
	at_us BIGINT NOT NULL, 
	topic_id INTEGER, 
	post_id INTEGER, 
	robot VARCHAR(32), 
	account_id INTEGER, 
	CONSTRAINT fk_events_account_id FOREIGN KEY(account_id) REFERENCES accounts (id), 
	CONSTRAINT fk_events_post_id FOREIGN KEY(post_id) REFERENCES posts (id)
);
INSERT INTO events VALUES(1,'post.created',1795402198929448,1,1,NULL,NULL);
INSERT INTO events VALUES(2,'post.created',1795402199088351,2,2,NULL,NULL);
INSERT INTO events VALUES(3,'post.created',1795402199333081,1,3,NULL,NULL);
INSERT INTO events VALUES(4,'post.created',1795402199354570,2,4,NULL,NULL);
INSERT INTO events VALUES(5,'post.edited',1795402199609677,2,4,NULL,NULL);
INSERT INTO events VALUES(6,'post.edited',1795402199637241,1,3,NULL,NULL);
INSERT INTO events VALUES(7,'post.edited',1795402202120377,1,3,NULL,NULL);
INSERT INTO events VALUES(8,'post.created',1795402225690379,3,5,NULL,NULL);
INSERT INTO events VALUES(9,'post.created',1795402225810775,3,6,NULL,NULL);
INSERT INTO events VALUES(10,'post.edited',1795402226044070,3,6,NULL,NULL);
INSERT INTO events VALUES(11,'post.edited',1795402226153964,3,6,NULL,NULL);
INSERT INTO events VALUES(12,'post.created',1795402237913976,4,7,NULL,NULL);
INSERT INTO events VALUES(13,'post.created',1795402238048484,4,8,NULL,NULL);
INSERT INTO events VALUES(14,'post.edited',1795402238204756,4,8,NULL,NULL);
INSERT INTO events VALUES(15,'post.created',1795402238207174,5,9,NULL,NULL);
INSERT INTO events VALUES(16,'post.edited',1795402238366672,4,8,NULL,NULL);
INSERT INTO events VALUES(17,'post.created',1795402238496128,5,10,NULL,NULL);
INSERT INTO events VALUES(18,'post.edited',1795402238554156,5,10,NULL,NULL);
INSERT INTO events VALUES(19,'post.edited',1795402274818849,5,10,NULL,NULL);
INSERT INTO events VALUES(20,'post.edited',1795402275168176,5,10,NULL,NULL);
INSERT INTO events VALUES(21,'post.created',1795402280296514,6,11,NULL,NULL);
INSERT INTO events VALUES(22,'post.created',1795402280494476,7,12,NULL,NULL);
INSERT INTO events VALUES(23,'post.created',1795402280966979,6,13,NULL,NULL);
INSERT INTO events VALUES(24,'post.created',1795402281051795,7,14,NULL,NULL);
INSERT INTO events VALUES(25,'post.edited',1795402281203381,7,14,NULL,NULL);
INSERT INTO events VALUES(26,'post.edited',1795402281434056,6,13,NULL,NULL);
INSERT INTO events VALUES(27,'post.created',1795402281518818,8,15,NULL,NULL);
INSERT INTO events VALUES(28,'post.created',1795402281714050,8,16,NULL,NULL);
CREATE TABLE used_keys (
	account_id INTEGER NOT NULL, 
	scope VARCHAR(40) NOT NULL, 
	"key" VARCHAR(200) NOT NULL, 
	ref INTEGER NOT NULL, 
	CONSTRAINT pk_used_keys PRIMARY KEY (account_id, scope, "key"), 
	CONSTRAINT fk_used_keys_account_id FOREIGN KEY(account_id) REFERENCES accounts (id)
);
CREATE TABLE robots (
	account_id INTEGER NOT NULL, 
	owner_id INTEGER, 
	rights JSON NOT NULL, 
	camera_role VARCHAR(10) NOT NULL, 
	camera_days INTEGER NOT NULL, 
	closed JSON NOT NULL, 
	CONSTRAINT pk_robots PRIMARY KEY (account_id), 
	CONSTRAINT fk_robots_account_id FOREIGN KEY(account_id) REFERENCES accounts (id), 
	CONSTRAINT fk_robots_owner_id FOREIGN KEY(owner_id) REFERENCES accounts (id)
);
INSERT INTO robots VALUES(2,1,'{"command": {"photo": "operator", "gesture": "operator", "move": "operator", "risky": "operator"}, "approve": "moderator", "release": "owner", "approval": [], "approve_own": false}','guest',0,'[]');
CREATE TABLE invites (
	hash VARCHAR(64) NOT NULL, 
	by_id INTEGER, 
	role VARCHAR(10) NOT NULL, 
	"left" INTEGER NOT NULL, 
	created_us BIGINT NOT NULL, 
	expires_us BIGINT NOT NULL, 
	CONSTRAINT pk_invites PRIMARY KEY (hash), 
	CONSTRAINT fk_invites_by_id FOREIGN KEY(by_id) REFERENCES accounts (id)
);
CREATE TABLE audit (
	id INTEGER NOT NULL PRIMARY KEY AUTOINCREMENT, 
	at_us BIGINT NOT NULL, 
	actor VARCHAR(40) NOT NULL, 
	action VARCHAR(40) NOT NULL, 
	target VARCHAR(80) NOT NULL, 
	detail JSON NOT NULL
);
INSERT INTO audit VALUES(1,1795402137945183,'shell','account.add','account:chief','{"kind": "human", "role": "admin"}');
INSERT INTO audit VALUES(2,1795402137965358,'shell','link.password','account:chief','{}');
INSERT INTO audit VALUES(3,1795402153337409,'shell','account.add','account:rex','{"kind": "robot_agent", "role": "member"}');
INSERT INTO audit VALUES(4,1795402153471568,'shell','token.add','account:rex','{"scopes": "read write"}');
INSERT INTO audit VALUES(5,1795402167785786,'shell','robot.change','robot:rex','{"before": {"owner": ""}, "owner": "chief"}');
INSERT INTO audit VALUES(6,1795402176532345,'shell','account.add','account:ann','{"kind": "human", "role": "member"}');
INSERT INTO audit VALUES(7,1795402176569336,'shell','link.enter','account:ann','{}');
INSERT INTO audit VALUES(8,1795402198251364,'shell','token.add','account:chief','{"scopes": "read write"}');
CREATE TABLE notices (
	account_id INTEGER NOT NULL, 
	post_id INTEGER NOT NULL, 
	reason VARCHAR(10) NOT NULL, 
	CONSTRAINT pk_notices PRIMARY KEY (account_id, post_id), 
	CONSTRAINT fk_notices_account_id FOREIGN KEY(account_id) REFERENCES accounts (id), 
	CONSTRAINT fk_notices_post_id FOREIGN KEY(post_id) REFERENCES posts (id)
);
INSERT INTO notices VALUES(1,3,'reply');
INSERT INTO notices VALUES(1,4,'reply');
INSERT INTO notices VALUES(1,6,'reply');
INSERT INTO notices VALUES(1,8,'reply');
INSERT INTO notices VALUES(1,10,'reply');
INSERT INTO notices VALUES(1,13,'reply');
INSERT INTO notices VALUES(1,14,'reply');
INSERT INTO notices VALUES(1,16,'reply');
CREATE TABLE notices_seen (
	account_id INTEGER NOT NULL, 
	post_id INTEGER NOT NULL, 
	CONSTRAINT pk_notices_seen PRIMARY KEY (account_id), 
	CONSTRAINT fk_notices_seen_account_id FOREIGN KEY(account_id) REFERENCES accounts (id)
);
CREATE TABLE commands (
	post_id INTEGER NOT NULL, 
	robot_id INTEGER NOT NULL, 
	reply_id INTEGER, 
	at_us BIGINT NOT NULL, 
	record JSON NOT NULL, 
	CONSTRAINT pk_commands PRIMARY KEY (post_id, robot_id), 
	CONSTRAINT fk_commands_post_id FOREIGN KEY(post_id) REFERENCES posts (id), 
	CONSTRAINT fk_commands_reply_id FOREIGN KEY(reply_id) REFERENCES posts (id), 
	CONSTRAINT fk_commands_robot_id FOREIGN KEY(robot_id) REFERENCES accounts (id)
);
INSERT INTO commands VALUES(2,2,4,1795402199728738,'{"post": "2", "topic": "2", "robot": "rex", "posted_at": "2026-11-23T02:49:59.088351+00:00", "trace_id": "b1890d293194", "status": "refused", "message": "", "plan": [], "notes": [], "verdict": {"decision": "refuse", "rule": "harm.attack", "reason": "I do not hurt or frighten anybody (`hit the child`)."}, "steps": [], "stop": null, "timings_ms": {"seen": 330.5}, "mind": "rules", "fallback": "", "models": [], "screened": null, "stopped_by": "", "summary": null, "approval": null, "pictures": []}');
INSERT INTO commands VALUES(1,2,3,1795402202149526,'{"post": "1", "topic": "1", "robot": "rex", "posted_at": "2026-11-23T02:49:58.929448+00:00", "trace_id": "5c1d4a964da8", "status": "refused", "message": "", "plan": [{"op": "move", "direction": "forward", "distance_m": 0.5}, {"op": "hello"}], "notes": [], "verdict": {"decision": "refuse", "rule": "guard.not_homed", "reason": ""}, "steps": [{"op": "move", "asked": {"direction": "forward", "distance_m": 0.5}, "measured": {}, "outcome": "refused", "reason": "not_homed", "message": "The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.", "duration_s": 0.0}, {"op": "hello", "asked": {}, "measured": {}, "outcome": "skipped", "reason": "", "message": "", "duration_s": 0.0}], "stop": null, "timings_ms": {"seen": 452.8, "done": 659.7}, "mind": "rules", "fallback": "", "models": [], "screened": null, "stopped_by": "", "summary": null, "approval": null, "pictures": []}');
INSERT INTO commands VALUES(5,2,6,1795402226176481,'{"post": "5", "topic": "3", "robot": "rex", "posted_at": "2026-11-23T02:50:25.690379+00:00", "trace_id": "a2ce3ebea342", "status": "refused", "message": "", "plan": [{"op": "move", "direction": "forward", "distance_m": 0.5}, {"op": "hello"}], "notes": [], "verdict": {"decision": "refuse", "rule": "guard.not_homed", "reason": ""}, "steps": [{"op": "move", "asked": {"direction": "forward", "distance_m": 0.5}, "measured": {}, "outcome": "refused", "reason": "not_homed", "message": "The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.", "duration_s": 0.0}, {"op": "hello", "asked": {}, "measured": {}, "outcome": "skipped", "reason": "", "message": "", "duration_s": 0.0}], "stop": null, "timings_ms": {"seen": 145.5, "done": 351.4}, "mind": "rules", "fallback": "", "models": [], "screened": null, "stopped_by": "", "summary": null, "approval": null, "pictures": []}');
INSERT INTO commands VALUES(7,2,8,1795402238444202,'{"post": "7", "topic": "4", "robot": "rex", "posted_at": "2026-11-23T02:50:37.913976+00:00", "trace_id": "1cbbe4f80d15", "status": "refused", "message": "", "plan": [{"op": "move", "direction": "backward", "distance_m": 2.0, "speed_mps": 0.2}, {"op": "hello"}], "notes": [], "verdict": {"decision": "refuse", "rule": "guard.not_homed", "reason": ""}, "steps": [{"op": "move", "asked": {"direction": "backward", "distance_m": 2.0, "speed_mps": 0.2}, "measured": {}, "outcome": "refused", "reason": "not_homed", "message": "The robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only.", "duration_s": 0.0}, {"op": "hello", "asked": {}, "measured": {}, "outcome": "skipped", "reason": "", "message": "", "duration_s": 0.0}], "stop": null, "timings_ms": {"seen": 160.6, "done": 298.3}, "mind": "rules", "fallback": "", "models": [], "screened": null, "stopped_by": "", "summary": null, "approval": null, "pictures": []}');
INSERT INTO commands VALUES(9,2,10,1795402275241946,'{"post": "9", "topic": "5", "robot": "rex", "posted_at": "2026-11-23T02:50:38.207174+00:00", "trace_id": "1ddff36e1db9", "status": "done", "message": "", "plan": [{"op": "get_front_image"}], "notes": [], "verdict": {"decision": "allow", "rule": "screen.passed", "reason": ""}, "steps": [{"op": "get_front_image", "asked": {}, "measured": {}, "outcome": "done", "reason": "", "message": "", "duration_s": 0.0}], "stop": null, "timings_ms": {"seen": 36212.6, "done": 36591.6}, "mind": "rules", "fallback": "", "models": [], "screened": null, "stopped_by": "", "summary": null, "approval": null, "pictures": [{"kind": "step", "step": 1}]}');
PRAGMA writable_schema=ON;
INSERT INTO sqlite_schema(type,name,tbl_name,rootpage,sql)VALUES('table','post_words','post_words',0,'CREATE VIRTUAL TABLE post_words USING fts5(words, chars, tokenize = ''porter unicode61 remove_diacritics 2'')');
CREATE TABLE IF NOT EXISTS 'post_words_data'(id INTEGER PRIMARY KEY, block BLOB);
INSERT INTO post_words_data VALUES(1,X'10834600');
INSERT INTO post_words_data VALUES(10,X'00000000020d1c000d1101010101010201010301010401010501010601010701010801010901010a01010b01010c01010000');
INSERT INTO post_words_data VALUES(137438953473,X'000000280d303164646666333665316462390a020401047365656e0a0202010574726163650a0203041109');
INSERT INTO post_words_data VALUES(274877906945,X'000000af0d303164646666333665316462390a010101320a020b01076163636f756e740a020502046761696e0a020902026e640a020d010262790a02120107636f6d6d616e640a02070102676f0a02100101690a020f02016e0a020a01036d61690a02060201650a020802057973656c660a021301026f6e0a02110104717565750a02020101730a020c0203616d650a0204020365656e0a0101037468650a020304016e0a020e0204726163650a010410060c0907070c07060608060a07090608070806');
INSERT INTO post_words_data VALUES(412316860417,X'000000aa0230310a0403040101320a010101610a0207020663636f756e740a0102046761696e0a0102026e640a01010262790a010107636f6d6d616e640a010102676f0a010101690a0102016e0a0101036d61690a010201650a0102057973656c660a0101026f660a020402016e0a01010570686f746f0a02080104717565750a010101730a010203616d650a0102037465700a0202010474616b650a0206020268650a0104016e0a01040705060a0806060b06050507050907050a080507080906');
INSERT INTO post_words_data VALUES(549755813889,X'000000da0230300a041f030101310a07070b13020232370a021e020b64646666333665316462390a021c010232310a0214010233360a0413070101360a02190104383139390a02220101390a02240101610a03090204667465720a0412070202736b0a02040101630a02230104646f6e650a06020b0d0104687474700a021d01066d65617375720a020501026f660a030e02057574636f6d0a0206010570686f746f0a050a05020569637475720a020c0101730a041507020365656e0a021102037465700a05030e010474616b650a03080204726163650a021b04070807100708060906060a07060b090b070a0b0a07080909');
INSERT INTO post_words_data VALUES(687194767361,X'0000004b0230300b02070101350b02080101610b020202026e640b020a0107666f72776172640b020601046d6574720b020901037265780b0204010477616c6b0b040304030276650b020b04060606070c09080a');
INSERT INTO post_words_data VALUES(824633720833,X'000000580230320c02070103616e640c020a01046261636b0c020601036375740c020201046d6574720c020801037265780c0204010573686f72740c020302056c6f776c690c0209010477616c6b0c0205030276650c020b040608090809080a0a09');
INSERT INTO post_words_data VALUES(962072674305,X'000000280d303166636132333363323337630d020401047365656e0d0202010574726163650d0203041109');
INSERT INTO post_words_data VALUES(1099511627777,X'000000270c3036663163313039346561350e020401047365656e0e0202010574726163650e0203041009');
INSERT INTO post_words_data VALUES(1236950581249,X'000000ae0230320e020b010b36663163313039346561350e0101076163636f756e740e020502046761696e0e020902026e640e020d010262790e02120107636f6d6d616e640e02070102676f0e02100101690e020f02016e0e020a01036d61690e02060201650e020802057973656c660e021301026f6e0e02110104717565750e02020101730e020c0203616d650e0204020365656e0e0101037468650e020304016e0e020e0204726163650e0104060f0c0907070c07060608060a07090608070806');
INSERT INTO post_words_data VALUES(1374389534721,X'000000660230300d02080101310d0203020b66636132333363323337630d010101320d02050101350d02090107666f72776172640d020701016d0d020a01026f660d020401047365656e0d0102037465700d0202010574726163650d01010477616c6b0d02060406060f06060c0607080809');
INSERT INTO post_words_data VALUES(1511828488193,X'0000002e0230610f0205010570686f746f0f020601037265780f0203010474616b650f02040104776169740f020204060a0809');
INSERT INTO post_words_data VALUES(1649267441665,X'000000280d3065333638326138623735616410020401047365656e10020201057472616365100203041109');
INSERT INTO post_words_data VALUES(2336462209025,X'00000534023030010208020c2521031109030106120903010207010c252103110903020c28220311090301013103082226190501021b02062226190206222a1902023237030443190102180204431902044719020135060255020136080259020b636262653466383064313508025c01013203022901021e020229010207010625060601023333040213010234350302550101350102090202260202080104263c020b63316434613936346461380302580101370802640104383139390304471901021c0204471902044b19010161010202040202040205020b32636533656265613334320602580204646d696e030232030232020236020466746572030253010211020253020257020767656e74726f6203024c03024c02025002016e03023103023102023503016401020b01020803020a02020a030579626f64690402090202736b03021f03021f02021f02017408022703047461636b04020f010c623138393064323933313934040216020361636b07020605047761726408022402046567756e03022c03022c02023002057574746f6e03023b03023b02023f01016303025f01021d02025f02026302046869656603022f03022f02023304026c6402020b02020c020275740702020102646f040204010466656e6303020a03020a02020a02046972737401020302021203021202021202066f727761726401020702022402020601022402077269676874656e0402080105677561726403021b03021b02021b010268610302050302050202050302726d04020e020365726503023e03023e0202420202697402020902020a02036f6d650310070c0405091a0a120310070c0405091a0a120210070c0405091e0a120203747470030442190102170204421902044619020375727404020601016903023701020302023702023b02036e746f02020502017303020b03020b02020b02017403040906030409060204090601016d030227030227020426060205616368696e030251030251020255020565617375720302200302200202200302747201020a040209020208020375737403020f03020f02020f02017903082d090e1203082d090e12020831090e1201026e6f03020603020602020603017403041c1101020502041c1102041c1501026f6e0306142d120306142d12020614311203026c690302190302190202190201720304301c0102070204301c0204341c02057574636f6d0302210302210202210204776e657203040e2203040e2202040e260104706167650302410302410202450204686f746f0902060105726566757302020201040228010202020402280204022c030178010205010203010449070202040104490701020401044d0701020302046f626f740306041632030604163202060416360203756c6503021a01020d02021a02021a01017303025601021402025602042b31020365656e030252010210020252020256030174030610250b030610250b020610290b0204686f72740702030204696d756c03021703021702021702056c6f776c6907020902016f030208030208020208020474616e6403023803023802023c040272740302150302150202150302657003021e03021e02021e010474616b6509020402026865020406060104033901020b020403390204033d02047261636503025701021502025702025b0107756e6b6e6f776e03020c03020c02020c01047761697409020203026c6b010404040102040102230204030401022301020501022304016c0202070302766501020c02022a02020b01022a01020b01022e02046865726503023603023602023a0203697468030439140304391402043d1404261613060610140707101006150c100f12120c0f0a0d06091108090f100f0f0a07070f12140c100d070e0a2314080f080c0f0d10100d0e150d12130d1210120f09191e1511101112090f0a0c0f0d0d09171212091b06160f');
CREATE TABLE IF NOT EXISTS 'post_words_idx'(segid, term, pgno, PRIMARY KEY(segid, term)) WITHOUT ROWID;
INSERT INTO post_words_idx VALUES(1,X'',2);
INSERT INTO post_words_idx VALUES(2,X'',2);
INSERT INTO post_words_idx VALUES(3,X'',2);
INSERT INTO post_words_idx VALUES(4,X'',2);
INSERT INTO post_words_idx VALUES(5,X'',2);
INSERT INTO post_words_idx VALUES(6,X'',2);
INSERT INTO post_words_idx VALUES(7,X'',2);
INSERT INTO post_words_idx VALUES(8,X'',2);
INSERT INTO post_words_idx VALUES(9,X'',2);
INSERT INTO post_words_idx VALUES(10,X'',2);
INSERT INTO post_words_idx VALUES(11,X'',2);
INSERT INTO post_words_idx VALUES(12,X'',2);
INSERT INTO post_words_idx VALUES(17,X'',2);
CREATE TABLE IF NOT EXISTS 'post_words_content'(id INTEGER PRIMARY KEY, c0, c1);
INSERT INTO post_words_content VALUES(1,replace('A first walk\n@rex walk forward 0.5 metres and wave','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(2,replace('Refused\n@rex walk into the wall and hit the child','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(3,replace('**Refused.**\n\nThe robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: `guard.not_homed`.\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | walk forward 0.5 m | – | refused |\n| 2 | wave | – | not begun |\n\nMy owner (`chief`) or an admin sets my home, where I stand, with the button Set home here on [my page](http://127.0.0.1:8199/robots/rex), or with `agentrob home rex` on my machine.\n\n*seen after 0.45 s · [trace `5c1d4a964da8`](http://127.0.0.1:8199/c/1)*','\n',char(10)),'');
INSERT INTO post_words_content VALUES(4,replace('**Refused.**\n\nI do not hurt or frighten anybody (`hit the child`). Rule: `harm.attack`.\n\n*seen after 0.33 s · [trace `b1890d293194`](http://127.0.0.1:8199/c/2)*','\n',char(10)),'');
INSERT INTO post_words_content VALUES(5,replace('A walk\n@rex walk forward 0.5 metres and wave','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(6,replace('**Refused.**\n\nThe robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: `guard.not_homed`.\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | walk forward 0.5 m | – | refused |\n| 2 | wave | – | not begun |\n\nMy owner (`chief`) or an admin sets my home, where I stand, with the button Set home here on [my page](http://127.0.0.1:8199/robots/rex), or with `agentrob home rex` on my machine.\n\n*seen after 0.15 s · [trace `a2ce3ebea342`](http://127.0.0.1:8199/c/5)*','\n',char(10)),'');
INSERT INTO post_words_content VALUES(7,replace('Cut short\n@rex walk back 2 metres slowly and wave','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(8,replace('**Refused.**\n\nThe robot has no home, so its fence is unknown; its owner must set home first. home_on_start homes simulated robots only. Rule: `guard.not_homed`.\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | walk backward 2 m at 0.2 m/s | – | refused |\n| 2 | wave | – | not begun |\n\nMy owner (`chief`) or an admin sets my home, where I stand, with the button Set home here on [my page](http://127.0.0.1:8199/robots/rex), or with `agentrob home rex` on my machine.\n\n*seen after 0.16 s · [trace `1cbbe4f80d15`](http://127.0.0.1:8199/c/7)*','\n',char(10)),'');
INSERT INTO post_words_content VALUES(9,replace('Waits\n@rex take a photo','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(10,replace('**Done.**\n\n| Step | Asked | Measured | Outcome |\n| ---: | --- | --- | --- |\n| 1 | take a photo | – | done |\n\nPictures: photo of step 1.\n\n*seen after 36.21 s · done after 36.6 s · [trace `1ddff36e1db9`](http://127.0.0.1:8199/c/9)*','\n',char(10)),'');
INSERT INTO post_words_content VALUES(11,replace('A walk\n@rex walk forward 0.5 metres and wave','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(12,replace('Cut short\n@rex walk back 2 metres slowly and wave','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(13,'Step 1 of 2: walk forward 0.5 m ...','');
INSERT INTO post_words_content VALUES(14,'Queued: the same account may command me again in 2 s, and then I go on by myself.','');
INSERT INTO post_words_content VALUES(15,replace('Waits\n@rex take a photo','\n',char(10)),' ');
INSERT INTO post_words_content VALUES(16,'Seen. *trace `e3682a8b75ad`*','');
CREATE TABLE IF NOT EXISTS 'post_words_docsize'(id INTEGER PRIMARY KEY, sz BLOB);
INSERT INTO post_words_docsize VALUES(1,X'0b00');
INSERT INTO post_words_docsize VALUES(2,X'0a00');
INSERT INTO post_words_docsize VALUES(3,X'5f00');
INSERT INTO post_words_docsize VALUES(4,X'1d00');
INSERT INTO post_words_docsize VALUES(5,X'0a00');
INSERT INTO post_words_docsize VALUES(6,X'5f00');
INSERT INTO post_words_docsize VALUES(7,X'0a00');
INSERT INTO post_words_docsize VALUES(8,X'6300');
INSERT INTO post_words_docsize VALUES(9,X'0500');
INSERT INTO post_words_docsize VALUES(10,X'2300');
INSERT INTO post_words_docsize VALUES(11,X'0a00');
INSERT INTO post_words_docsize VALUES(12,X'0a00');
INSERT INTO post_words_docsize VALUES(13,X'0900');
INSERT INTO post_words_docsize VALUES(14,X'1200');
INSERT INTO post_words_docsize VALUES(15,X'0500');
INSERT INTO post_words_docsize VALUES(16,X'0300');
CREATE TABLE IF NOT EXISTS 'post_words_config'(k PRIMARY KEY, v) WITHOUT ROWID;
INSERT INTO post_words_config VALUES('version',4);
CREATE TABLE post_meanings (
	post_id INTEGER NOT NULL, 
	version INTEGER NOT NULL, 
	model VARCHAR(20) NOT NULL, 
	vector BLOB NOT NULL, 
	CONSTRAINT pk_post_meanings PRIMARY KEY (post_id)
);
CREATE TABLE attempts (
	id INTEGER NOT NULL, 
	"key" VARCHAR(64) NOT NULL, 
	at_us BIGINT NOT NULL, 
	CONSTRAINT pk_attempts PRIMARY KEY (id)
);
CREATE TABLE stage (
	robot VARCHAR(32) NOT NULL, 
	card JSON NOT NULL, 
	seen_us BIGINT NOT NULL, 
	frame BLOB, 
	shown_us BIGINT, 
	CONSTRAINT pk_stage PRIMARY KEY (robot)
);
CREATE TABLE stage_viewers (
	process VARCHAR(16) NOT NULL, 
	robot VARCHAR(32) NOT NULL, 
	viewers INTEGER NOT NULL, 
	until_us BIGINT NOT NULL, 
	CONSTRAINT pk_stage_viewers PRIMARY KEY (process, robot)
);
CREATE TABLE topic_tags (
	topic_id INTEGER NOT NULL, 
	tag VARCHAR(24) NOT NULL, 
	CONSTRAINT pk_topic_tags PRIMARY KEY (topic_id, tag), 
	CONSTRAINT fk_topic_tags_topic_id FOREIGN KEY(topic_id) REFERENCES topics (id)
);
CREATE TABLE topic_reads (
	account_id INTEGER NOT NULL, 
	topic_id INTEGER NOT NULL, 
	post_id INTEGER NOT NULL, 
	CONSTRAINT pk_topic_reads PRIMARY KEY (account_id, topic_id), 
	CONSTRAINT fk_topic_reads_account_id FOREIGN KEY(account_id) REFERENCES accounts (id), 
	CONSTRAINT fk_topic_reads_topic_id FOREIGN KEY(topic_id) REFERENCES topics (id)
);
DELETE FROM sqlite_sequence;
INSERT INTO sqlite_sequence VALUES('accounts',3);
INSERT INTO sqlite_sequence VALUES('audit',8);
INSERT INTO sqlite_sequence VALUES('topics',8);
INSERT INTO sqlite_sequence VALUES('posts',16);
INSERT INTO sqlite_sequence VALUES('events',28);
INSERT INTO sqlite_sequence VALUES('images',1);
CREATE INDEX ix_topics_board_id_last_post_id ON topics (board_id, last_post_id);
CREATE INDEX ix_topics_last_post_id ON topics (last_post_id);
CREATE INDEX ix_posts_author_id_id ON posts (author_id, id);
CREATE INDEX ix_posts_topic_id_id ON posts (topic_id, id);
CREATE INDEX ix_post_images_image_id ON post_images (image_id);
CREATE INDEX ix_events_topic_id_id ON events (topic_id, id);
CREATE INDEX ix_images_account_id_id ON images (account_id, id);
CREATE INDEX ix_audit_target_id ON audit (target, id);
CREATE TRIGGER post_words_erased AFTER UPDATE OF raw ON posts WHEN new.raw = '' BEGIN DELETE FROM post_words WHERE rowid = new.id; END;
CREATE TRIGGER post_meanings_erased AFTER UPDATE OF raw ON posts WHEN NEW.raw = '' BEGIN DELETE FROM post_meanings WHERE post_id = NEW.id; END;
CREATE INDEX ix_attempts_at_us ON attempts (at_us);
CREATE INDEX ix_attempts_key_at_us ON attempts ("key", at_us);
CREATE INDEX ix_topic_tags_tag_topic_id ON topic_tags (tag, topic_id);
PRAGMA writable_schema=OFF;
COMMIT;
