<?php
// Help moodle_lti.py: make a course with people, register a tool by hand, activate a registered tool, or return marks. The
// request is JSON on standard input: `config` is the path of Moodle's config.php, `action` is what to do.

require(__DIR__ . '/import.php');
require_once($CFG->dirroot . '/mod/lti/locallib.php');
require_once($CFG->dirroot . '/user/lib.php');
require_once($CFG->libdir . '/gradelib.php');

// Make a course with a teacher and students.
function make_course(array $people): array {
    global $CFG;
    set_config('curlsecurityblockedhosts', ''); // Moodle may fetch our keys from this machine
    set_config('curlsecurityallowedport', '');
    $course = create_test_course();
    $answer = ['software' => 'Moodle ' . $CFG->release, 'root' => $CFG->wwwroot, 'course' => $course->id];
    foreach ($people as $name => $email) {
        $user = ['username' => $name . uniqid(), 'password' => 'Qdot-1-velocity!', 'auth' => 'manual', 'confirmed' => 1,
            'mnethostid' => $CFG->mnet_localhost_id, 'firstname' => ucfirst($name), 'lastname' => '-', 'email' => $email,
            'idnumber' => $name];
        $CFG->allowaccountssameemail = 1;
        enrol_try_internal_enrol($course->id, user_create_user($user, true, false), $name === 'grace' ? 3 : 5);
        $answer['people'][$name] = ['username' => $user['username'], 'password' => $user['password']];
    }
    return $answer;
}

// Add a tool as an administrator does who configures it manually; return its number and client ID.
function add_tool(array $addresses): array {
    global $DB;
    $config = (object) ['lti_typename' => 'qdot by hand', 'lti_toolurl' => $addresses['tool'], 'lti_ltiversion' => LTI_VERSION_1P3,
        'lti_keytype' => LTI_JWK_KEYSET, 'lti_publickeyset' => $addresses['keys'], 'lti_initiatelogin' => $addresses['login'],
        'lti_redirectionuris' => $addresses['redirect'], 'lti_contentitem' => 1, 'lti_coursevisible' => 2,
        'lti_launchcontainer' => LTI_LAUNCH_CONTAINER_EMBED_NO_BLOCKS, 'lti_sendname' => 1, 'lti_sendemailaddr' => 1,
        'lti_acceptgrades' => 1, 'ltiservice_gradesynchronization' => 2, 'ltiservice_memberships' => 1,
        'lti_description' => '', 'lti_icon' => '', 'lti_secureicon' => '', 'lti_customparameters' => ''];
    $type = (object) ['state' => LTI_TOOL_STATE_CONFIGURED];
    $id = lti_add_type($type, $config);
    return ['tool' => $id, 'client' => $DB->get_field('lti_types', 'clientid', ['id' => $id])];
}

// Activate the tool that was registered last, as an administrator does by the button Activate.
function activate_tool(): array {
    global $DB;
    $type = $DB->get_record_sql('SELECT * FROM {lti_types} ORDER BY id DESC LIMIT 1');
    $was_pending = $type->state == LTI_TOOL_STATE_PENDING;
    lti_set_state_for_type($type->id, LTI_TOOL_STATE_CONFIGURED);
    return ['tool' => $was_pending ? $type->id : 0, 'name' => $type->name];
}

// Return the marks in a course's gradebook, by activity and person.
function list_marks(int $course): array {
    global $DB;
    $sql = 'SELECT ' . $DB->sql_concat('i.itemname', "' '", 'u.idnumber') . ', g.finalgrade
              FROM {grade_grades} g JOIN {user} u ON u.id = g.userid JOIN {grade_items} i ON i.id = g.itemid
             WHERE i.courseid = ? AND i.itemmodule = ? AND g.finalgrade IS NOT NULL';
    $items = 'SELECT itemname, grademax FROM {grade_items} WHERE courseid = ? AND itemmodule = ?';
    return ['marks' => $DB->get_records_sql_menu($sql, [$course, 'lti']),
        'highest' => $DB->get_records_sql_menu($items, [$course, 'lti'])];
}

\core\session\manager::set_user(get_admin());
echo json_encode(match ($request['action']) {
    'make course' => make_course($request['people']),
    'add tool' => add_tool($request['addresses']),
    'activate tool' => activate_tool(),
    'list marks' => list_marks($request['course']),
});
