// YAML as a tree with places, and what is refused of it.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "unity.h"
#include "wire/tree.h"

static tree_memory_t memory;
static char sentence[512];
static tree_error_t error = {sentence, sizeof sentence};

void setUp(void) { sentence[0] = '\0'; }
void tearDown(void) { tree_memory_free(&memory); }

static const tree_t* read(const char* text) { return tree_from_yaml(&memory, &error, "f.yaml", text, strlen(text)); }

static void test_every_value_has_its_kind_and_every_key_its_place(void) {
    static const struct {
        const char* text;
        tree_kind_t kind;
        double real;
    } scalars[] = {
        {"1", TREE_INTEGER, 1},
        {"-0", TREE_INTEGER, -0.0},
        {"+7", TREE_INTEGER, 7},
        {"1.5", TREE_REAL, 1.5},
        {".5", TREE_REAL, 0.5},
        {"1e3", TREE_REAL, 1000},
        {"5.", TREE_REAL, 5},
        {"4e-324", TREE_REAL, 4e-324},
        {"9223372036854775808", TREE_REAL, 9223372036854775808.0},
        {".inf", TREE_REAL, INFINITY},
        {"-.Inf", TREE_REAL, -INFINITY},
        {"1e999", TREE_REAL, INFINITY},
        {"true", TREE_BOOLEAN, 0},
        {"FALSE", TREE_BOOLEAN, 0},
        {"yes", TREE_TEXT, 0},
        {"~", TREE_NULL, 0},
        {"null", TREE_NULL, 0},
        {"", TREE_NULL, 0},
        {"'1'", TREE_TEXT, 0},
        {"\"true\"", TREE_TEXT, 0},
        {"0x10", TREE_TEXT, 0},
        {"1,5", TREE_TEXT, 0},
        {"1e", TREE_TEXT, 0},
        {"--1", TREE_TEXT, 0},
        {"inf", TREE_TEXT, 0},
        {"nan", TREE_TEXT, 0},
        {"1 2", TREE_TEXT, 0},
        {"e", TREE_TEXT, 0},
        {".", TREE_TEXT, 0},
        {"1_000", TREE_TEXT, 0},
    };
    for (size_t k = 0; k < sizeof scalars / sizeof scalars[0]; k++) {
        char text[64];
        snprintf(text, sizeof text, "a:\n  key: %s\n", scalars[k].text);
        const tree_t* const value = tree_get(tree_get(read(text), "a"), "key");
        TEST_ASSERT_NOT_NULL_MESSAGE(value, sentence);
        TEST_ASSERT_EQUAL_INT_MESSAGE(scalars[k].kind, value->kind, scalars[k].text);
        TEST_ASSERT_EQUAL_MEMORY_MESSAGE(&scalars[k].real, &value->real, sizeof value->real, scalars[k].text);
        TEST_ASSERT_EQUAL_INT(2, value->line);
    }
    const tree_t* const root = read("# comment\nlist:\n  - {x: 1,  yy: [2, 3]}\n");
    const tree_t* const map = tree_get(root, "list")->entries[0].value;
    TEST_ASSERT_EQUAL_INT(3, map->entries[1].line);
    TEST_ASSERT_EQUAL_INT(13, map->entries[1].column);
    char place[64];
    tree_place(map->entries[1].value->entries[1].value, place, sizeof place);
    TEST_ASSERT_EQUAL_STRING("f.yaml:3:21: list[0].yy[1]", place);
}

static void test_json_is_yaml_too(void) {
    const tree_t* const root = read("{\"a\": [1.0, -0.0, true, null, \"\\u00e4\\n\\/\"], \"b\": {\"c\": 5e-324}}");
    TEST_ASSERT_NOT_NULL_MESSAGE(root, sentence);
    TEST_ASSERT_EQUAL_STRING("\xc3\xa4\n/", tree_get(root, "a")->entries[4].value->text);
    TEST_ASSERT_TRUE(signbit(tree_get(root, "a")->entries[1].value->real));
    TEST_ASSERT_TRUE(tree_get(tree_get(root, "b"), "c")->real == 5e-324);
}

static const struct {
    const char *text, *refusal; ///< how it begins
    const char* what;           ///< what else is in it
} bad[] = {
    {"", "f.yaml:", NULL},
    {"# nothing\n", "f.yaml:", NULL},
    {"a: 1\nb: 2\na: 3\n", "f.yaml:3:1: a: this key stands there twice", NULL},
    {"a: &x 1\nb: *x\n", "f.yaml:2:", "b: an alias (*...); write out what it stands for"},
    {"a: &x {b: 1}\nc:\n  <<: *x\n", "f.yaml:3:", "c.<<: an alias"},
    {"a: !!float 1\n", "f.yaml:1:", "a: a tag"},
    {"a: !!map {b: 1}\n", "f.yaml:1:", "a: a tag"},
    {"a: \"x\\0y\"\n", "f.yaml:1:", "a: a text with a zero character in it"},
    {"\"a\\0b\": 1\n", "f.yaml:1:", "a text with a zero character in it"},
    {"? [1, 2]\n: 3\n", "f.yaml:1:3: a key that is no word", NULL},
    {"a: [1, 2\nb: 3\n", "f.yaml:", "not YAML from here on"},
    {"a: 'open\n", "f.yaml:", NULL},
    {"a: 1\n---\nb: 2\n", "f.yaml:2:1: a second document begins here", NULL},
    {"a: 1\n b: 2\n", "f.yaml:", "not YAML from here on"},
    {"a: \"\\q\"\n", "f.yaml:1:", NULL},
    {"a: 1\n%YAML 1.1\n", "f.yaml:2:1: a directive", NULL},
    {"%# Tw\x9bn\na: 1\n", "f.yaml:1:1: a control character, or bytes that are no UTF-8", NULL},
    {"a: 1\nb: \x1b[31m\n", "f.yaml:2:1: a control character", NULL},
    {"\xff\xfe", "f.yaml:", NULL},
};

static void test_each_kind_of_bad_text_is_refused_with_its_place(void) {
    for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
        setUp();
        TEST_ASSERT_NULL_MESSAGE(read(bad[k].text), bad[k].text);
        TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE(bad[k].refusal, sentence, strlen(bad[k].refusal), sentence);
        TEST_ASSERT_TRUE_MESSAGE(bad[k].what == NULL || strstr(sentence, bad[k].what) != NULL, sentence);
    }
}

/// Texts that grow without bound: depth, keys, entries, size, and the aliases that double what they stand for.
static void test_what_grows_without_bound_is_refused_soon(void) {
    static char text[TREE_YAML_MAX + 2];
    for (int kind = 0; kind < 5; kind++) {
        setUp();
        text[0] = '\0';
        if (kind == 0) {
            memset(text, '[', 100000);
            text[100000] = '\0';
        } else if (kind == 1 || kind == 2) {
            char* end = text;
            for (int i = 0; end - text < 200000; i++) {
                end += kind == 1 ? sprintf(end, "k%d: 1\n", i) : sprintf(end, "- 1\n");
            }
        } else if (kind == 3) {
            memset(text, '#', TREE_YAML_MAX + 1);
            text[TREE_YAML_MAX + 1] = '\0';
        } else {
            char* end = text + sprintf(text, "a0: &a0 [1, 1]\n");
            for (int i = 1; i < 50; i++) {
                end += sprintf(end, "a%d: &a%d [*a%d, *a%d]\n", i, i, i - 1, i - 1);
            }
        }
        TEST_ASSERT_NULL(read(text));
        TEST_ASSERT_EQUAL_STRING_LEN("f.yaml", sentence, 6);
        tearDown();
    }
}

static void test_nothing_that_steers_a_terminal_is_left_in_a_text(void) {
    char text[] =
        "a\x1b[31m\xc2\x9b"
        "b\x9b\x7f\r\n\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80\xe2\x82";
    tree_make_harmless(text);
    TEST_ASSERT_EQUAL_STRING("a?[31m??b????\xc3\xa4\xe2\x82\xac\xf0\x9f\x98\x80??", text);
}

static void test_the_nearest_word_is_found_and_none_is_guessed(void) {
    static const char* const known[] = {"standoff_m", "weights", "method"};
    TEST_ASSERT_EQUAL_STRING("standoff_m", tree_nearest("standof_m", known, 3));
    TEST_ASSERT_EQUAL_STRING("standoff_m", tree_nearest("stand_off_m", known, 3));
    TEST_ASSERT_EQUAL_STRING("method", tree_nearest("metod", known, 3));
    TEST_ASSERT_NULL(tree_nearest("fuel", known, 3));
    TEST_ASSERT_NULL(tree_nearest("", known, 3));
}

int main(void) {
    UNITY_BEGIN();
    RUN_TEST(test_every_value_has_its_kind_and_every_key_its_place);
    RUN_TEST(test_json_is_yaml_too);
    RUN_TEST(test_each_kind_of_bad_text_is_refused_with_its_place);
    RUN_TEST(test_what_grows_without_bound_is_refused_soon);
    RUN_TEST(test_nothing_that_steers_a_terminal_is_left_in_a_text);
    RUN_TEST(test_the_nearest_word_is_found_and_none_is_guessed);
    return UNITY_END();
}
