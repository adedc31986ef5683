<?php
// A course in Moodle with a teacher, an administrator and two students who can log in: `php ready.php < request.json`, which answers in JSON.
//
// The request: `config` (Moodle's config.php), `course` (its name) and `people`: login, name, email, role, password.

require(__DIR__ . '/../import.php');
require_once($CFG->dirroot . '/user/lib.php');

\core\session\manager::set_user(get_admin());
$number = 1 + $DB->count_records('course', ['fullname' => $request['course']]);
$names = ['fullname' => $request['course'], 'shortname' => "kinematics-$number"];
$course = create_course((object) ($names + ['category' => 1, 'numsections' => 2]));
$logins = [];
foreach ($request['people'] as $person) {
    // Nobody of an earlier run has the address by which marks are imported.
    foreach ($DB->get_records('user', ['email' => $person['email']]) as $earlier) {
        $DB->set_field('user', 'email', "{$earlier->username}@earlier.example.org", ['id' => $earlier->id]);
    }
    // People of this run alone, who know of no other course.
    $logins[$person['login']] = "{$person['login']}$number";
    [$first, $last] = explode(' ', $person['name'], 2);
    $id = user_create_user((object) [
        'username' => $logins[$person['login']], 'firstname' => $first, 'lastname' => $last, 'email' => $person['email'],
        'password' => $person['password'], 'auth' => 'manual', 'confirmed' => 1, 'mnethostid' => $CFG->mnet_localhost_id,
    ], true, false);
    if ($person['role'] === 'admin') {
        set_config('siteadmins', "{$CFG->siteadmins},$id");
        continue;
    }
    enrol_try_internal_enrol($course->id, $id, $DB->get_field('role', 'id', ['shortname' => $person['role']], MUST_EXIST));
}
// A restore is waited for, not left to the next cron.
set_config('enableasyncbackup', 0);
// Tours of the pages would lie over them.
$DB->set_field('tool_usertours_tours', 'enabled', 0);
\cache_helper::purge_by_definition('tool_usertours', 'tourdata');
echo json_encode([
    'course' => (int) $course->id, 'context' => context_course::instance($course->id)->id, 'logins' => $logins,
    'address' => $CFG->wwwroot, 'software' => 'Moodle ' . $CFG->release,
]);
